// The health of a link over days: figures of intervals, a baseline, and alarms, in constant memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/status.hpp"
#include "decode/distribution.hpp"
#include "decode/statistics.hpp"

namespace biss::live {

/// The unit of line delay and ACK.
enum class LinkUnit : std::uint8_t {
  picosecond,  ///< a capture
  clock,       ///< a port: whole clocks of MA
};

/// A request cycle. A value is absent if it cannot be measured.
struct HealthSample {
  CycleStatus status = CycleStatus::ok;
  bool error = false;    ///< nE is active
  bool warning = false;  ///< nW is active
  bool noisy = false;    ///< a pulse, or SLO changes close to a sampling point
  std::optional<std::int64_t> delay{};
  std::optional<std::int64_t> ack{};
  /// From a sampling point to the nearest change of SLO, in thousandths of a period.
  std::optional<std::int64_t> margin{};
  std::optional<Picoseconds> period{};
};

/// Quantities with a value for each interval: the median, or for the margin the value that a tenth
/// of the cycles is below.
enum class Level : std::uint8_t { delay, ack, margin };
inline constexpr std::size_t level_count = 3;

constexpr std::string_view name_of(Level level) {
  constexpr std::string_view names[] = {"line delay", "ACK", "margin"};
  return names[static_cast<std::size_t>(level)];
}

/// Cycles that are counted and compared with the baseline as a share of all cycles.
enum class Event : std::uint8_t {
  damaged,  ///< a fault that is not part of a gap
  gap,      ///< two or more requests in a row without an answer, then an answer; counted once
  noisy,
  warning,
  error,
  shifted,  ///< at a port: the answer came in another clock than usual in this interval
};
inline constexpr std::size_t event_count = 6;

constexpr std::string_view name_of(Event event) {
  constexpr std::string_view names[] = {"damaged",  "gaps",   "noisy",
                                        "warnings", "errors", "shifted"};
  return names[static_cast<std::size_t>(event)];
}

/// The figures of an interval, or of several.
struct HealthPoint {
  std::int64_t time = 0;  ///< its begin, in seconds since 1970
  std::uint64_t cycles = 0;
  std::uint64_t good = 0;  ///< frames without a fault
  std::array<std::uint64_t, event_count> events{};
  std::array<std::optional<std::int64_t>, level_count> levels{};

  std::uint64_t& count(Event event) { return events[static_cast<std::size_t>(event)]; }
  const auto& level(Level level) const { return levels[static_cast<std::size_t>(level)]; }
  /// Adds the counts; each level becomes the mean, weighted by the cycles.
  void add(const HealthPoint& other);
};

enum class Alarm : std::uint8_t {
  silent,   ///< no good frame in an interval
  contact,  ///< answers are missing again and again for some requests
  encoder,  ///< nE or nW is active more often, or ACK has become longer
  noise,    ///< damaged frames, pulses, less margin
  cable,    ///< less margin and another line delay
  delay,    ///< another line delay
};
inline constexpr std::size_t alarm_count = 6;

constexpr std::string_view name_of(Alarm alarm) {
  constexpr std::string_view names[] = {"silent", "contact", "encoder", "noise", "cable", "delay"};
  return names[static_cast<std::size_t>(alarm)];
}

/// An alarm that began or ended.
struct AlarmChange {
  std::int64_t time = 0;
  Alarm alarm{};
  bool begins = false;
  std::string reason;
  /// Cycles with a fault since the first one that was watched.
  std::uint64_t faults = 0;
};

/// The intervals that later ones are compared with.
struct Baseline {
  std::uint64_t intervals = 0;
  /// The lowest and the highest value of a level, and the largest share of an event.
  std::array<std::optional<std::array<std::int64_t, 2>>, level_count> ranges{};
  std::array<double, event_count> shares{};

  void add(const HealthPoint& point);
};

/// All that outlives a restart.
struct HealthState {
  decode::Counts counts;
  Baseline baseline;
  std::uint64_t intervals = 0;  ///< after the baseline
  /// The baseline, and later intervals without an alarm that are no longer in `recent`.
  HealthPoint reference;
  std::int64_t period = 0;  ///< of MA, in picoseconds
  /// The last ones, for the alarms.
  std::vector<HealthPoint> recent;
  /// All of them; when there are too many, each two become one.
  std::vector<HealthPoint> history;
  /// How many intervals a point of the history has, and how many its last one has so far.
  std::uint64_t joined = 1;
  std::uint64_t last_joined = 0;
  /// The reason of each alarm; empty: it is off. And for how many intervals it was not true.
  std::array<std::string, alarm_count> reasons{};
  std::array<std::uint32_t, alarm_count> quiet{};
  /// The last ones.
  std::vector<AlarmChange> changes;
};

struct HealthSetup {
  LinkUnit unit = LinkUnit::picosecond;
  /// Intervals of the baseline.
  std::uint64_t baseline = 30;
};

class LinkHealth {
 public:
  /// An interval with fewer cycles is joined with the next one.
  static constexpr std::uint64_t cycles_min = 100;

  explicit LinkHealth(const HealthSetup& setup) : setup_(setup) {}

  void add(const HealthSample& sample);
  /// Ends the interval, which began at `time`.
  /// \param even_if_few also with fewer cycles than cycles_min, or with none
  /// \return nothing if it has too few cycles, and goes on
  std::optional<HealthPoint> end_interval(std::int64_t time, bool even_if_few = false);
  /// The figures of an interval, as end_interval() returned them to another run.
  void take(const HealthPoint& point);
  /// The interval that goes on: its counts.
  const HealthPoint& interval() const { return now_.point; }
  /// The alarms that the last interval began or ended.
  const std::vector<AlarmChange>& changes() const { return changes_; }

  const HealthState& state() const { return state_; }
  /// Goes on from the end of another run.
  void restore(HealthState state) { state_ = std::move(state); }
  void restore(const HealthPoint& interval, const decode::Counts& counts) {
    now_.point = interval;
    state_.counts = counts;
  }
  /// `412.0 ns`.
  std::string level_text(Level level, std::int64_t value) const;
  /// A line: how a level changes over the history, if that is certain; else empty.
  std::string trend_text(Level level) const;

 private:
  struct Interval {
    HealthPoint point;
    std::array<decode::Distribution, level_count> levels;
  };
  void count_missing();
  void keep(const HealthPoint& point);
  void judge(std::int64_t time);
  std::string reason_of(Alarm alarm) const;
  std::string more_often(Event event, std::string_view what) const;
  std::string moved(Level level, std::int64_t part = 1) const;

  HealthSetup setup_;
  HealthState state_;
  Interval now_;
  std::uint64_t missing_in_a_row_ = 0;
  std::vector<AlarmChange> changes_;
};

}  // namespace biss::live
