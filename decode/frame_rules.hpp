// Rules on a single request and its frame: limits of the master, structure, times.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "decode/check.hpp"
#include "decode/limits.hpp"
#include "decode/times.hpp"

namespace biss::decode {

/// Whether a request with this status proves nothing: the device could not answer it in full, or
/// the capture does not show the answer.
constexpr bool is_no_evidence(CycleStatus status) {
  return status == CycleStatus::truncated || !has_whole_clock(status);
}

/// START was found, and MA ran as it should.
constexpr bool has_times(CycleStatus status) {
  return is_good(status) || status == CycleStatus::crc || status == CycleStatus::ack_range ||
         status == CycleStatus::cds || status == CycleStatus::stop_bit;
}

class FrameRules {
 public:
  FrameRules(const CheckSetup& setup, Tallies& tallies)
      : timing_(setup.timing),
        unidirectional_(setup.unidirectional || (setup.format && setup.format->cds0)),
        tallies_(tallies),
        limits_(setup.timing, setup.resolution) {}

  void push(std::uint64_t number, const Cycle& cycle) {
    judge_master(number, cycle);
    if (const auto before = std::exchange(without_stop_, std::nullopt)) {
      tallies_.count(Rule::stop_clock, false, *before, "the last clock, for STOP, is missing");
    }
    judge_reset(number, cycle);
    judge_idle(number, cycle);
    judge_frame(number, cycle);
    judge_bits(number, cycle);
    if (has_times(cycle.status)) judge_times(number, cycle);
    if (cycle.line_delay) line_delay_ = cycle.line_delay;
  }

  /// After the last cycle. A single request may be too short for START, but not every request of a
  /// capture.
  void finish() {
    if (has_start_) return;
    for (std::uint64_t i = 0; i < unanswered_.count; ++i) {
      count_start(unanswered_.first, unanswered_.status, unanswered_.period);
    }
  }

  /// Whether MA must rest after an aborted request for as long as a whole one takes (Renishaw).
  static bool knows_reset(const DeviceTiming& timing) {
    return timing.timeout.rule == TimeoutRule::cycle && timing.cycle_min.count != 0;
  }
  /// The reason why no frame is a case of frame_structure; empty if one is.
  std::string_view no_frame() const {
    if (tallies_.result(Rule::frame_structure).cases != 0) return {};
    return has_truncated_ ? "every request ends before the last bit of the frame"
                          : "no request shows a frame";
  }

 private:
  // Within a frame the line delay may vary by this share of a period (D2, characteristics, row 8).
  static constexpr std::int64_t jitter_share = 4;

  // Requests without START that may have been too short: the end of the capture decides.
  struct Unanswered {
    std::uint64_t count = 0;
    std::uint64_t first = 0;
    CycleStatus status{};
    Picoseconds period{};
  };

  // A request that ended before its frame did, and how long a whole one takes.
  struct Aborted {
    std::uint64_t number = 0;
    Picoseconds begin{};
    Picoseconds whole{};
  };

  static bool was_checked(const Cycle& cycle) {
    return std::any_of(cycle.crc_ok.begin(), cycle.crc_ok.end(),
                       [](const auto& right) { return right.has_value(); });
  }

  static bool is_silent(CycleStatus status) {
    return status == CycleStatus::no_response || status == CycleStatus::no_start;
  }

  static bool has_structure(CycleStatus status) {
    return has_times(status) && status != CycleStatus::cds && status != CycleStatus::stop_bit;
  }

  // The rules for the master: if it breaks them, the other rules prove nothing. The timeout is judged
  // below, for more cycles than `decode` marks.
  void judge_master(std::uint64_t number, const Cycle& cycle) {
    for (const Comparison& each : limits_.compare(cycle)) {
      if (each.rule == Rule::timeout_shortest || each.rule == Rule::timeout_longest) continue;
      const Picoseconds margin =
          each.bound_is_maximum ? each.bound - each.value : each.value - each.bound;
      tallies_.measure(each.rule, {each.bound.count, each.value.count, margin.count},
                       each.doubt.count, number);
    }
  }

  // After an aborted request the encoder waits until a whole one would be over.
  void judge_reset(std::uint64_t number, const Cycle& cycle) {
    if (cycle.status == CycleStatus::ma_glitch || !knows_reset(timing_)) return;
    if (aborted_ && cycle.status != CycleStatus::cut_start) {
      const Picoseconds since = elapsed(aborted_->begin, cycle.time);
      tallies_.at_least(Rule::reset, since, aborted_->whole, aborted_->whole / oscillator_divisor,
                        aborted_->number);
    }
    aborted_.reset();
    const bool ends_early = cycle.status == CycleStatus::truncated ||
                            cycle.status == CycleStatus::no_start ||
                            cycle.status == CycleStatus::no_response;
    if (!ends_early || !cycle.period || cycle.rising_edges >= usual_edges_) return;
    if (cycle.cdm == true) tallies_.count(Rule::reset, false, number, "MA rests low");
    aborted_ = {number, cycle.time,
                std::max(timing_.cycle_min, std::int64_t{usual_edges_} * *cycle.period)};
  }

  // SLO low at a request is the device's fault only if the master has waited long enough.
  void judge_idle(std::uint64_t number, const Cycle& cycle) {
    const bool early = !ready_by_ || cycle.time < *ready_by_;
    if (cycle.status == CycleStatus::not_ready) {
      if (!early) tallies_.count(Rule::slo_idle, false, number, "SLO is low before the request");
    } else if (!is_no_evidence(cycle.status) || cycle.status == CycleStatus::truncated) {
      tallies_.count(Rule::slo_idle, true, number);
    }
    judge_ready(number, cycle, early);
    const Picoseconds longest = std::max({timing_.timeout.time, biss_static_timeout_max,
                                          2 * cycle.period.value_or(period_of(biss_clock_min))});
    // A request that is cut may keep the encoder busy for as long as a whole one.
    const bool whole = has_times(cycle.status);
    const std::int64_t edges =
        whole ? cycle.rising_edges : std::max(cycle.rising_edges, usual_edges_);
    if (cycle.period) period_ = *cycle.period;
    const Picoseconds clocks = std::max(cycle.clocked, (edges + 1) * period_);
    ready_by_ = shifted(cycle.time, clocks + longest + biss_line_delay_max +
                                        (whole ? Picoseconds{} : biss_busy_max));
  }

  // The master waits for SLO. An encoder with a fixed cycle time may get its request by time: the
  // request then arrives when the encoder is ready, and the master sees SLO rise a line delay later.
  void judge_ready(std::uint64_t number, const Cycle& cycle, bool early) {
    if (!cycle.signal || !cycle.signal->ready || is_no_evidence(cycle.status)) return;
    const Picoseconds ready = *cycle.signal->ready;
    // Else it is SLO that stays low.
    if (ready < Picoseconds{} && !(early && ready_by_)) return;
    const auto delay = cycle.line_delay ? cycle.line_delay : line_delay_;
    const bool by_time = timing_.timeout.rule == TimeoutRule::cycle;
    if (by_time && !delay) return;
    Picoseconds limit{};
    Picoseconds doubt = 2 * tallies_.resolution();
    if (by_time) {
      limit = -*delay;
      doubt += *cycle.period / jitter_share;
    }
    tallies_.measure(Rule::ready, {limit.count, ready.count, (ready - limit).count}, doubt.count,
                     number);
  }

  void judge_frame(std::uint64_t number, const Cycle& cycle) {
    const CycleStatus status = cycle.status;
    has_truncated_ = has_truncated_ || status == CycleStatus::truncated;
    has_start_ = has_start_ || has_times(status) || status == CycleStatus::truncated;
    if (is_no_evidence(status) || status == CycleStatus::not_ready) return;
    if (status == CycleStatus::response_range) return judge_response(number, cycle);
    const Picoseconds asked =
        std::int64_t{cycle.rising_edges} * cycle.period.value_or(Picoseconds{});
    const bool long_enough = (usual_edges_ != 0 && cycle.rising_edges >= usual_edges_) ||
                             asked > biss_busy_max + biss_line_delay_max;
    const Picoseconds period = cycle.period.value_or(Picoseconds{});
    if (is_silent(status) && !long_enough) {
      if (unanswered_.count++ == 0) {
        unanswered_.first = number;
        unanswered_.status = status;
        unanswered_.period = period;
      }
      return;
    }
    const bool good = has_structure(status);
    count_start(number, status, period);
    if (is_good(status)) usual_edges_ = std::max(usual_edges_, cycle.rising_edges);
    if (good && was_checked(cycle)) {
      tallies_.count_sampled(Rule::frame_crc, status != CycleStatus::crc, *cycle.period, number);
    }
  }

  // SLO fell before the second rising edge of MA, or so late that the time was not measured.
  void judge_response(std::uint64_t number, const Cycle& cycle) {
    const Picoseconds period = cycle.period.value_or(Picoseconds{});
    if (cycle.early && tallies_.shows_bits(period)) {
      return tallies_.at_least(Rule::line_delay, -*cycle.early, {}, {}, number);
    }
    tallies_.count_sampled(Rule::line_delay, false, period, number,
                           cycle.early ? "SLO falls too early" : "SLO falls too late");
  }

  void count_start(std::uint64_t number, CycleStatus status, Picoseconds period) {
    tallies_.count_sampled(Rule::frame_structure, has_structure(status), period, number,
                           name_of(status));
    tallies_.count_sampled(Rule::start, !is_silent(status), period, number, name_of(status));
  }

  // START is followed by CDS; the frame ends in STOP.
  void judge_bits(std::uint64_t number, const Cycle& cycle) {
    if (!has_times(cycle.status) || !cycle.period) return;
    const auto cds = cycle.cds();
    if (unidirectional_ && cds) {
      tallies_.count_sampled(Rule::cds_zero, !*cds, *cycle.period, number, "CDS is 1");
    }
    // If a checksum is wrong, the bits may not fit the format.
    const bool has_stop = is_good(cycle.status) || cycle.status == CycleStatus::stop_bit;
    if (!has_stop || !was_checked(cycle)) return;
    const bool clocked = !cycle.frame || cycle.frame->stop_seen;
    if (!clocked) {
      // The end of the capture may hide the last clock: the next request shows that it does not.
      without_stop_ = number;
      return;
    }
    tallies_.count(Rule::stop_clock, true, number);
    tallies_.count_sampled(Rule::stop, cycle.status != CycleStatus::stop_bit, *cycle.period, number,
                           "STOP is 1");
  }

  void judge_times(std::uint64_t number, const Cycle& cycle) {
    if (!cycle.period) return;
    const Picoseconds jitter = *cycle.period / jitter_share;
    if (cycle.line_delay) {
      tallies_.at_most(Rule::line_delay, *cycle.line_delay, biss_line_delay_max, {}, number);
    }
    if (cycle.ack) {
      const AckBounds bounds = ack_bounds(timing_, *cycle.period);
      tallies_.at_least(Rule::ack_shortest, *cycle.ack,
                        std::int64_t{bounds.min_clocks} * *cycle.period, jitter, number);
      tallies_.at_most(Rule::ack_longest, *cycle.ack,
                       std::int64_t{bounds.max_clocks} * *cycle.period, jitter, number);
    }
    if (cycle.release && cycle.line_delay) judge_timeout(number, cycle);
  }

  void judge_timeout(std::uint64_t number, const Cycle& cycle) {
    const Picoseconds seen = *cycle.release - *cycle.line_delay;
    const auto [least, most] = release_bounds(timing_, cycle);
    tallies_.at_least(Rule::timeout_shortest, seen, least, release_doubt(cycle, least), number);
    tallies_.at_most(Rule::timeout_longest, seen, most, release_doubt(cycle, most), number);
  }

  DeviceTiming timing_;
  bool unidirectional_;
  Tallies& tallies_;
  LimitWatch limits_;
  // The longest request that was answered with a frame, in rising edges of MA.
  std::uint32_t usual_edges_ = 0;
  Unanswered unanswered_;
  std::optional<Aborted> aborted_;
  // The number of the previous cycle, if it is a good frame without STOP.
  std::optional<std::uint64_t> without_stop_;
  bool has_start_ = false;
  bool has_truncated_ = false;
  // The time by which SLO must be high again after the previous request.
  std::optional<Picoseconds> ready_by_;
  // The last ones that were measured.
  std::optional<Picoseconds> line_delay_;
  Picoseconds period_{};
};

}  // namespace biss::decode
