// Counts and distributions over the rows of a capture.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "decode/cycle.hpp"
#include "decode/distribution.hpp"
#include "decode/limits.hpp"

namespace biss::decode {

/// Counts and distributions over all cycles added. Times in picoseconds, duty in thousandths.
class Statistics {
 public:
  /// \param exceeded its limits
  void add(const Cycle& cycle, LimitSet exceeded = 0);

  std::uint64_t cycles() const { return cycles_; }
  std::uint64_t count(CycleStatus status) const {
    return by_status_[static_cast<std::size_t>(status)];
  }
  /// Rows that are ok, or unchecked.
  std::uint64_t good() const { return count(CycleStatus::ok) + count(CycleStatus::unchecked); }
  /// Rows that are neither ok nor cut by an end of the capture.
  std::uint64_t failed() const {
    return cycles_ - count(CycleStatus::ok) - count(CycleStatus::cut_start) -
           count(CycleStatus::cut_end);
  }
  /// Good frames in which a channel reported an error or a warning.
  std::uint64_t errors() const { return errors_; }
  std::uint64_t warnings() const { return warnings_; }

  /// Rows that exceed this limit, and any limit.
  std::uint64_t count(Limit limit) const { return by_limit_[static_cast<std::size_t>(limit)]; }
  std::uint64_t limited() const { return limited_; }

  /// Cycles that were sampled close to a change of SLO, and cycles in which that can be seen.
  std::uint64_t marginal() const { return marginal_; }
  std::uint64_t margin_judged() const { return margin_judged_; }

  const Distribution& period() const { return period_; }
  /// From the begin of one cycle to the begin of the next.
  const Distribution& interval() const { return interval_; }
  const Distribution& line_delay() const { return line_delay_; }
  const Distribution& ack() const { return ack_; }
  /// ACK in clocks of its own cycle.
  const Distribution& ack_clocks() const { return ack_clocks_; }
  /// How long before the edge of ACK SLO fell, in cycles with `response_range`.
  const Distribution& early() const { return early_; }
  const Distribution& duty() const { return duty_; }

 private:
  std::uint64_t cycles_ = 0;
  std::array<std::uint64_t, cycle_status_count> by_status_{};
  std::uint64_t errors_ = 0;
  std::uint64_t warnings_ = 0;
  std::array<std::uint64_t, limit_count> by_limit_{};
  std::uint64_t limited_ = 0;
  std::uint64_t marginal_ = 0;
  std::uint64_t margin_judged_ = 0;
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
