// The options of `biss simulate` that describe the line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/units.hpp"
#include "sim/line_setup.hpp"
#include "verbs/common/format_option.hpp"

namespace biss::verbs {

/// The options that describe the line.
struct LineOptions {
  FormatArguments device;
  /// The options that are members of it: clock with error and duty, slaves, position, pause, seed,
  /// registers, accesses, retries, and whether the far end is recorded.
  sim::LineSetup setup;
  Millimetres cable{};
  /// Empty: the device's longest.
  std::optional<Picoseconds> internal_delay;
  /// One way each in the cable. Empty: half of the delay of the cable.
  std::optional<Picoseconds> ma_delay;
  std::optional<Picoseconds> slo_delay;
  /// The jitter of each line without its own value.
  Picoseconds jitter{};
  std::optional<Picoseconds> ma_jitter;
  std::optional<Picoseconds> slo_jitter;
  /// Empty: the device's shortest.
  std::optional<Picoseconds> processing;
  std::optional<Hertz> rate;
  std::string motion = "ramp";
  std::vector<std::string> faults;
  /// `FORMAT@CYCLE`; empty: the format does not change.
  std::string then{};
  bool no_compensation = false;
  /// The range of the sign of life.
  std::string counter = "count_1_63";
  /// First values of the signs of life by channel; the last one applies to all further channels.
  std::vector<std::uint64_t> counter_start{};
  /// As in LineSetup.
  std::int64_t drift = 0;
  /// Busy time of a register access per byte: frames (`12`) or a time (`3ms`); empty: none.
  std::string register_busy{};
};

/// The line that the options describe, checked against the device and its data sheet; else one line
/// of text (wrong usage). \pre options.device.format is given
tl::expected<sim::LineSetup, std::string> line_setup(const LineOptions& options);

/// Why the encoder cannot send START as early as the options require at this clock: it comes after
/// the position was sampled. Empty if it can. Not for the clock of a recorded master.
std::string wrong_start(const sim::LineSetup& setup);

/// Reads the value of `--register-busy`: frames, or a time, which is rounded up to frames of
/// `interval`.
/// \return an empty text, or one line why the value is wrong; `busy` is then unchanged
std::string read_busy(const std::string& text, Picoseconds interval, RegisterBusy& busy);

}  // namespace biss::verbs
