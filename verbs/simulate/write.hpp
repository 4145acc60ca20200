// Runs the simulated line and writes the capture, the truth and the outcomes.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/configure/configuration.hpp"
#include "report/summary.hpp"
#include "sim/line_setup.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

inline constexpr std::uint64_t usual_cycles = 100;

struct WriteOptions {
  std::string output;
  std::optional<Hertz> sample_rate;
  /// Empty: usual_cycles, or more if the accesses take more.
  std::optional<std::uint64_t> cycles;
  /// Files; empty: none.
  std::string truth;
  /// A row per access, `cycle,time_ns,id,access,address,name,data,outcome` as in `biss registers`,
  /// and `cycles`. `cycle` and `time_ns` belong to the master's first step, zeros before the
  /// control frame included; `cycles` is the number of cycles. `data` are the bytes read, or
  /// written with a good echo. `outcome` is `ok`, the one cause, or `unfinished` if the run ended
  /// first. A command has a row for each slave that it addresses; a broadcast has one row without
  /// ID.
  std::string outcomes;
  /// The master reads format and timing from the encoders' registers first.
  bool configure = false;
  /// The line from this cycle on, with another format of as many channels.
  std::optional<sim::LineSetup> then{};
  std::uint64_t then_cycle = 0;
};

/// Returns data_failed if the master could not configure itself; the capture then contains its
/// requests.
ExitStatus write_line(const sim::LineSetup& setup, const WriteOptions& options, Host& host);

// ---- The result of a configuration as text, also for a real line

/// One line: the cause, the step, the slave, and how the access went.
std::string fault_text(const ConfigureFault& fault);
/// ConfigureOptions::findings that adds a line for each. \pre lines outlives it
EdsFindingTaker lines_of_findings(std::vector<std::string>& lines);
void add_configuration(report::Summary& out, const Result<Configuration, ConfigureFault>& found,
                       const std::vector<std::string>& findings);

}  // namespace biss::verbs
