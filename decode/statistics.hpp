// Counts and distributions over the rows of a capture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "decode/cycle.hpp"
#include "decode/distribution.hpp"
#include "decode/limits.hpp"

namespace biss::decode {

/// Counts of request cycles, which add up.
struct Counts {
  std::uint64_t cycles = 0;
  std::array<std::uint64_t, cycle_status_count> by_status{};
  /// Good frames in which a channel reported an error or a warning.
  std::uint64_t errors = 0;
  std::uint64_t warnings = 0;
  /// Rows that exceed each limit, and any limit.
  std::array<std::uint64_t, limit_count> by_limit{};
  std::uint64_t limited = 0;
  /// Cycles that were sampled close to a change of SLO, and cycles in which that can be seen.
  std::uint64_t marginal = 0;
  std::uint64_t margin_judged = 0;

  bool operator==(const Counts&) const = default;
  void add(const Counts& other);
  std::uint64_t count(CycleStatus status) const {
    return by_status[static_cast<std::size_t>(status)];
  }
  /// Cycles with a named cause: neither good nor cut by an end of the capture.
  std::uint64_t faults() const;
  /// The most frequent cause; `ok` if there is no fault.
  CycleStatus foremost_fault() const;
};

/// Counts and distributions over all cycles added. Times in picoseconds, duty in thousandths.
class Statistics {
 public:
  /// \param exceeded its limits
  void add(const Cycle& cycle, LimitSet exceeded = 0);

  const Counts& counts() const { return counts_; }
  std::uint64_t cycles() const { return counts_.cycles; }
  std::uint64_t count(CycleStatus status) const { return counts_.count(status); }
  /// Rows that are ok, or unchecked.
  std::uint64_t good() const { return count(CycleStatus::ok) + count(CycleStatus::unchecked); }
  /// Rows that are neither ok nor cut by an end of the capture.
  std::uint64_t failed() const {
    return cycles() - count(CycleStatus::ok) - count(CycleStatus::cut_start) -
           count(CycleStatus::cut_end);
  }
  std::uint64_t errors() const { return counts_.errors; }
  std::uint64_t warnings() const { return counts_.warnings; }
  std::uint64_t count(Limit limit) const {
    return counts_.by_limit[static_cast<std::size_t>(limit)];
  }
  std::uint64_t limited() const { return counts_.limited; }
  std::uint64_t marginal() const { return counts_.marginal; }
  std::uint64_t margin_judged() const { return counts_.margin_judged; }

  const Distribution& period() const { return period_; }
  /// From the beginning of one cycle to the beginning of the next.
  const Distribution& interval() const { return interval_; }
  const Distribution& line_delay() const { return line_delay_; }
  const Distribution& ack() const { return ack_; }
  /// ACK in clocks of its own cycle.
  const Distribution& ack_clocks() const { return ack_clocks_; }
  /// How long before the edge of ACK SLO fell, in cycles with `response_range`.
  const Distribution& early() const { return early_; }
  const Distribution& duty() const { return duty_; }

 private:
  Counts counts_;
  Distribution period_;
  Distribution interval_;
  Distribution line_delay_;
  Distribution ack_;
  Distribution ack_clocks_;
  Distribution early_;
  Distribution duty_;
  std::optional<Picoseconds> last_time_;
};

}  // namespace biss::decode
