// The results of `biss watch`: its state file, rows, alarms, and figures for other programs.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "biss/base/units.hpp"
#include "cli/live/publish.hpp"
#include "live/link_health.hpp"
#include "report/table.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/journal.hpp"
#include "verbs/common/output.hpp"

namespace biss::cli {

/// How much of a file was watched.
struct FileMark {
  std::uint64_t bytes = 0;
  std::int64_t time = 0;  ///< of the last change, in nanoseconds since 1970
  std::uint64_t cycles = 0;
  /// The number of bytes at its beginning that were hashed, and their hash: another one is another
  /// file.
  std::uint64_t head = 0;
  std::uint64_t hash = 0;
};

/// The state file: lines of JSON. The header has the options, a snapshot all figures; after that a
/// line for each interval, and for each second within one.
struct SavedHealth {
  live::LinkHealth health;
  /// By the number of the file in its file system.
  std::map<std::uint64_t, FileMark> files{};
  /// The format that the first capture showed; empty: not known yet, or given.
  std::string format{};
};

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

/// Every function throws a VerbError if the rows cannot be written. A state that cannot be written is
/// named once, and tried again.
class HealthLog {
 public:
  /// Goes on from the end of the state file.
  HealthLog(HealthLogOptions options, verbs::Host& host);

  /// \param time since the first cycle of its capture or line
  /// \param now the time of the cycle, in seconds since 1970
  void add(const live::HealthSample& sample, Picoseconds time, std::int64_t now);
  /// A time without a cycle: the interval may end.
  void wait(Picoseconds time, std::int64_t now);
  /// Ends the interval if it has enough cycles: the next cycle is of another capture.
  void end_capture();
  /// The next cycles are of this file, which `key` names. Its cycles are counted.
  FileMark& begin_file(std::uint64_t key);
  std::string& format() { return saved_.format; }
  bool is_empty() const { return saved_.health.state().counts.cycles == 0; }
  /// Writes what is new since the last second.
  /// \param interval that ended; null: none did
  void save(const live::HealthPoint* interval = nullptr);

  /// Writes the rest, and the summary.
  /// \return data_failed if an alarm is on
  verbs::ExitStatus finish();

 private:
  bool end_interval(bool even_if_few = false);
  void write_state(const live::HealthPoint* interval);

  HealthLogOptions options_;
  verbs::Host& host_;
  SavedHealth saved_;
  verbs::Journal journal_;
  std::map<std::uint64_t, FileMark>::value_type* file_ = nullptr;
  verbs::Output output_;
  std::unique_ptr<report::TableWriter> rows_;
  Publisher publisher_;
  std::optional<Picoseconds> began_;
  std::int64_t began_at_ = 0;
  std::uint64_t unsaved_ = 0;
  std::uint64_t snapshot_bytes_ = 0;
  bool state_failed_ = false;
  std::chrono::steady_clock::time_point saved_at_{};
};

/// The rows and the summary of a state file, without watching.
verbs::ExitStatus show_health(const std::string& state, const std::string& output,
                              report::Format to, verbs::Host& host);

}  // namespace biss::cli
