// Runs the simulated line and writes what `biss simulate` is asked for: capture, truth, outcomes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "biss/base/units.hpp"
#include "cli/common/exit_status.hpp"
#include "sim/line_setup.hpp"

namespace biss::cli {

inline constexpr std::uint64_t usual_cycles = 100;

struct WriteOptions {
  std::string output;
  std::optional<Hertz> sample_rate;
  /// Nothing: usual_cycles, or as many more as the accesses take.
  std::optional<std::uint64_t> cycles;
  /// Empty: not wanted.
  std::string truth;
  std::string outcomes;
  /// The master begins with knowing nothing.
  bool configure = false;
};

/// data_failed where the master could not configure itself; the capture then shows how it tried.
ExitStatus write_line(const sim::LineSetup& setup, const WriteOptions& options);

}  // namespace biss::cli
