// `biss simulate --ma-from` and `--slo-from`: one side of the line is recorded, the other simulated.
#pragma once

#include <string>

#include "verbs/common/host.hpp"
#include "verbs/common/raw_samples.hpp"
#include "verbs/simulate/setup.hpp"
#include "verbs/simulate/write.hpp"

namespace biss::verbs {

struct ReplayOptions {
  /// Exactly one of these two is set.
  std::string ma_from;
  std::string slo_from;
  /// Of --ma-from: a file with the positions to send, and a command that records MA again with our
  /// answers; empty: none.
  std::string positions;
  std::string rerun;
  /// The layout of a capture of raw samples.
  RawSamples raw;
  /// Names of its lines; empty: found by name, else by behaviour.
  std::string ma;
  std::string slo;
  /// The file for the rows of our master; empty: none.
  std::string readings;
  /// Our master has the clock that the user gives, not the recorded one.
  bool own_clock = false;
};

/// Our encoder answers the recorded MA; with `rerun` until the master clocks every request up to
/// STOP. Without a timeout given it has the adaptive one, the
/// shortest, so that it is ready for any master.
ExitStatus replay_ma(const ReplayOptions& options, const WriteOptions& write,
                     const LineOptions& line, Host& host);

/// Our master reads the recorded SLO.
ExitStatus replay_slo(const ReplayOptions& options, const WriteOptions& write,
                      const LineOptions& line, Host& host);

}  // namespace biss::verbs
