// What `biss simulate` is asked for, and the line it means.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "cli/common/format_option.hpp"
#include "sim/control_master.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/line_setup.hpp"

namespace biss::cli {

/// The options that describe the line.
struct LineOptions {
  FormatArguments device;
  Hertz clock = megahertz(1);
  /// As LineSetup has them.
  std::int32_t clock_error_ppm = 0;
  std::uint32_t duty_per_mille = 500;
  Millimetres cable{};
  /// The device's longest by default.
  std::optional<Picoseconds> internal_delay;
  /// One way each in the cable; half of the cable's by default.
  std::optional<Picoseconds> ma_delay;
  std::optional<Picoseconds> slo_delay;
  /// Of both lines, where they have none of their own.
  Picoseconds jitter{};
  std::optional<Picoseconds> ma_jitter;
  std::optional<Picoseconds> slo_jitter;
  Picoseconds processing{};
  std::uint64_t slaves = 1;
  std::optional<Hertz> rate;
  std::string motion = "ramp";
  std::vector<std::string> faults;
  bool no_compensation = false;
  bool at_slave = false;
  std::uint64_t seed = 1;
  /// The name of a range of the sign of life.
  std::string counter = "count_1_63";
  /// First values of the signs of life, the channels' in order; the last one goes for the rest.
  std::vector<std::uint64_t> counter_start{};
  /// As LineSetup has it.
  std::int64_t drift = 0;
  /// As LineSetup has them.
  std::vector<sim::EncoderRegisters> registers{};
  std::vector<sim::ControlAccess> accesses{};
  /// As read_busy() takes it; empty: at once.
  std::string register_busy{};
  std::uint64_t retries = 0;
};

/// A line, or one line of text that says why there is none (usage: exit status 2).
struct LineChoice {
  std::optional<sim::LineSetup> setup;
  std::string error;

  explicit operator bool() const { return setup.has_value(); }
};

/// Checks the options against the device and its data sheet. \pre options.device.format is given
LineChoice choose_line(const LineOptions& options);

}  // namespace biss::cli
