// `biss simulate --ma-from` and `--slo-from`: one side of the line is a capture, the other ours.
#pragma once

#include <optional>
#include <string>

#include "cli/common/exit_status.hpp"
#include "cli/common/raw_samples.hpp"
#include "cli/simulate/setup.hpp"

namespace biss::cli {

struct ReplayOptions {
  /// Exactly one of these two is given.
  std::string ma_from;
  std::string slo_from;
  /// What it does not say of itself.
  RawSamples raw;
  /// Names of lines in it; empty: found by name, else by behaviour.
  std::string ma;
  std::string slo;
  /// Where our master's rows go; empty: nowhere.
  std::string readings;
  /// Our master's clock is the user's and not the recorded one.
  bool own_clock = false;
  std::optional<Hertz> sample_rate;
  std::string output;
  std::string truth;
};

/// Our encoder behind the recorded MA. A format without a timeout of its own gets the adaptive one,
/// the shortest, so that it is ready for any master.
ExitStatus replay_ma(const ReplayOptions& options, const LineOptions& line);

/// Our master before the recorded SLO.
ExitStatus replay_slo(const ReplayOptions& options, const LineOptions& line);

}  // namespace biss::cli
