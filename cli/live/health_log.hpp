// The results of `biss watch`: its state file, rows, alarms, and figures for other programs.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "biss/base/units.hpp"
#include "cli/live/publish.hpp"
#include "cli/live/saved_health.hpp"
#include "live/link_health.hpp"
#include "report/table.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/journal.hpp"
#include "verbs/common/output.hpp"

namespace biss::cli {

struct HealthLogOptions {
  live::HealthSetup health;
  Picoseconds interval = milliseconds(10'000);
  std::string state;
  std::string output;
  report::Format to = report::Format::table;
  PublishOptions publish;
  /// The options by which cycles are read; a state with others is refused.
  std::string settings;
};

/// Every function throws a VerbError if the state or the rows cannot be written.
class HealthLog {
 public:
  /// Goes on from the end of the state file.
  HealthLog(HealthLogOptions options, verbs::Host& host);

  /// \param time since the first cycle of its capture or line
  /// \param now the time of the cycle, in seconds since 1970
  void add(const live::HealthSample& sample, Picoseconds time, std::int64_t now);
  /// Ends the interval if it has enough cycles: the next cycle is of another capture.
  void end_capture();
  /// The next cycles are of this file, which `key` names. Its cycles are counted.
  FileMark& begin_file(std::uint64_t key);
  /// Writes what is new since the last second.
  void save() { save(nullptr); }

  /// Writes the rest, and the summary.
  /// \return data_failed if an alarm is on
  verbs::ExitStatus finish();

 private:
  void end_interval();
  void save(const live::HealthPoint* interval);

  HealthLogOptions options_;
  verbs::Host& host_;
  SavedHealth saved_;
  verbs::Journal journal_;
  std::uint64_t file_ = 0;
  FileMark* mark_ = nullptr;  // of this file
  verbs::Output output_;
  std::unique_ptr<report::TableWriter> rows_;
  Publisher publisher_;
  std::optional<Picoseconds> began_;
  std::int64_t began_at_ = 0;
  std::uint64_t unsaved_ = 0;
  std::chrono::steady_clock::time_point saved_at_{};
};

/// The rows and the summary of a state file, without watching.
verbs::ExitStatus show_health(const std::string& state, const std::string& output,
                              report::Format to, verbs::Host& host);

}  // namespace biss::cli
