// Rules on the signals of MA and SLO: levels, pulses, line delay, sampling.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "biss/timing/cable.hpp"
#include "decode/check.hpp"
#include "decode/frame_rules.hpp"

namespace biss::decode {

class SignalRules {
 public:
  SignalRules(const CheckSetup& setup, Tallies& tallies) : setup_(setup), tallies_(tallies) {
    if (!setup.compensated) return;
    tallies_.make_advice(Rule::sampling_uncompensated);
    tallies_.explain(Rule::sampling_uncompensated,
                     "for a master that does not compensate the line delay");
  }

  /// \param cycle with Cycle::signal; without it only the line delay is judged
  void push(std::uint64_t number, const Cycle& cycle) {
    if (cycle.status == CycleStatus::ma_glitch) {
      tallies_.count(Rule::glitch_ma, false, number, "a pulse on MA is not a request");
    }
    if (!cycle.period || cycle.status == CycleStatus::unknown_level) return;
    if (cycle.signal) {
      judge_ma(number, cycle);
      judge_pulses(number, cycle);
      judge_clocks(number, cycle);
      if (has_times(cycle.status) && cycle.signal->changes) {
        if (cycle.line_delay) judge_changes(number, cycle);
        judge_sampling(number, cycle);
      }
    }
    if (cycle.line_delay && has_times(cycle.status)) {
      judge_delay(number, cycle);
      judge_cable(number, cycle);
    }
  }

 private:
  // The line delay may vary within a frame by a fourth of a period, up and down (D2, row 8). The
  // rest of half a period is the least distance of a change of SLO from a sampling point.
  static constexpr std::int64_t jitter_share = 4;
  static constexpr std::int64_t quarter = 25'000;  // in thousandths of a per cent
  // MA is high or low for at least this share of the shortest period of the encoder (D2, rows 3, 4).
  static constexpr std::int64_t level_percent = 40;
  // No request has more.
  static constexpr std::int64_t most_clocks = 1'000'000;

  // In thousandths of a per cent.
  static std::int64_t percent(Picoseconds time, Picoseconds period) {
    return 100'000 * time.count / period.count;
  }

  void judge_ma(std::uint64_t number, const Cycle& cycle) {
    if (cycle.signal->ma_shortest) {
      const Picoseconds limit = period_of(setup_.timing.clock_max) * level_percent / 100;
      tallies_.at_least(Rule::ma_level, *cycle.signal->ma_shortest, limit,
                        limit / oscillator_divisor, number);
    }
    if (!setup_.timing.duty_even || !cycle.duty_per_mille || is_no_evidence(cycle.status)) return;
    if (8 * tallies_.resolution() > *cycle.period) {
      return tallies_.too_coarse(Rule::duty, *cycle.period / 8);
    }
    // In thousandths of a per cent.
    const std::int64_t high = 100 * std::int64_t{*cycle.duty_per_mille};
    const std::int64_t limit =
        high < 50'000 ? 1'000 * level_percent : 1'000 * (100 - level_percent);
    const std::int64_t margin = high < 50'000 ? high - limit : limit - high;
    // One more thousandth, to which the duty is rounded.
    tallies_.measure(Rule::duty, {limit, high, margin},
                     percent(tallies_.resolution(), *cycle.period) + 100, number);
  }

  void judge_pulses(std::uint64_t number, const Cycle& cycle) {
    const LineSignal& signal = *cycle.signal;
    // The shortest pulse that the capture shows for certain is of its resolution.
    const bool coarse = 2 * tallies_.resolution() > signal.pulse_max;
    const auto judge = [&](Rule rule, std::uint32_t pulses, std::string_view note) {
      if (coarse) return tallies_.too_coarse(rule, signal.pulse_max / 2);
      if (pulses == 0) return tallies_.count(rule, true, number);
      tallies_.count(rule, false, number, note);
      tallies_.add_faults(rule, pulses - 1U, number);
    };
    judge(Rule::glitch_ma, signal.ma_pulses, "a level of MA is too short for a clock");
    judge(Rule::glitch_slo, signal.slo_pulses, "a level of SLO is too short for a bit");
  }

  void judge_clocks(std::uint64_t number, const Cycle& cycle) {
    const bool complete = is_good(cycle.status) || cycle.status == CycleStatus::crc ||
                          cycle.status == CycleStatus::ack_range;
    const auto& needed = cycle.signal->frame_clocks;
    if (!complete || !needed || cycle.rising_edges < *needed) return;
    const Picoseconds frame_end = std::int64_t{*needed} * *cycle.period;
    const auto end = clocks_end(cycle, frame_end);
    if (!end) return;
    const std::int64_t extra = std::int64_t{cycle.rising_edges} - std::int64_t{*needed};
    const std::int64_t limit =
        std::min(most_clocks, clocks_to_cover(*end - frame_end, *cycle.period));
    // One for the line delay to the encoder, one for rounding.
    tallies_.measure(Rule::extra_clocks, {1'000 * limit, 1'000 * extra, 1'000 * (limit - extra)},
                     2'000, number);
  }

  void judge_changes(std::uint64_t number, const Cycle& cycle) {
    const LineSignal::Changes& changes = *cycle.signal->changes;
    // The changes count from the second rising edge, also if the encoder counts from another one.
    const Picoseconds delay =
        *cycle.line_delay + (std::int64_t{cycle.ack_edge} - 1) * *cycle.period;
    const Picoseconds seen = std::max(changes.latest - delay, delay - changes.earliest);
    const Picoseconds limit = *cycle.period / jitter_share;
    tallies_.at_most(Rule::line_delay_jitter, seen, limit, limit / oscillator_divisor, number);
  }

  // How far the changes of SLO are from the sampling points, in shares of a period.
  void judge_sampling(std::uint64_t number, const Cycle& cycle) {
    const LineSignal::Changes& changes = *cycle.signal->changes;
    const Picoseconds period = *cycle.period;
    const auto judge = [&](Rule rule, Picoseconds distance) {
      if (8 * tallies_.resolution() > period) return tallies_.too_coarse(rule, period / 8);
      const std::int64_t worst = percent(distance, period);
      tallies_.measure(rule, {quarter, worst, worst - quarter},
                       percent(2 * tallies_.resolution(), period) + 100, number);
    };
    if (setup_.compensated) {
      const Picoseconds off =
          std::max(changes.latest - changes.sampled, changes.sampled - changes.earliest);
      judge(Rule::sampling_margin, period / 2 - off);
    }
    judge(Rule::sampling_uncompensated, period / 2 - changes.latest);
  }

  void judge_delay(std::uint64_t number, const Cycle& cycle) {
    const Picoseconds delay = *cycle.line_delay;
    most_delay_ = least_delay_ ? std::max(most_delay_, delay) : delay;
    least_delay_ = std::min(least_delay_.value_or(delay), delay);
    const Picoseconds limit = *cycle.period / 2;
    tallies_.at_most(Rule::line_delay_drift, most_delay_ - *least_delay_, limit,
                     limit / oscillator_divisor, number);
  }

  void judge_cable(std::uint64_t number, const Cycle& cycle) {
    if (!setup_.renishaw_cables) return;
    // A clock just above the clock of the table counts as that clock.
    const std::int64_t periods = std::max<std::int64_t>(1, std::int64_t{cycle.rising_edges} - 1);
    const Picoseconds doubt =
        *cycle.period / (oscillator_divisor / 2) + tallies_.resolution() / periods;
    const Hertz clock = rate_of(*cycle.period + doubt);
    const auto longest = cable_max_compensated(clock);
    if (!longest) return;
    const Picoseconds limit = line_delay(*longest, setup_.timing.internal_delay_max);
    tallies_.at_most(Rule::cable, *cycle.line_delay, limit, *cycle.period / jitter_share, number);
  }

  // The time from the start of the request during which the master may send clocks: an encoder that
  // is ready takes an edge of MA as a request.
  std::optional<Picoseconds> clocks_end(const Cycle& cycle, Picoseconds frame_end) const {
    const Timeout& timeout = setup_.timing.timeout;
    if (cycle.release && cycle.line_delay) {
      const Picoseconds released = *cycle.release - *cycle.line_delay;
      if (released < -*cycle.period) return cycle.clocked + released;
    }
    const bool by_time = timeout.rule == TimeoutRule::cycle;
    // The limit for a frame that is longer than the time is unknown.
    if (by_time && frame_end + *cycle.period < timeout.time) return timeout.time;
    return std::nullopt;
  }

  const CheckSetup& setup_;
  Tallies& tallies_;
  // The line delays of the capture so far.
  std::optional<Picoseconds> least_delay_;
  Picoseconds most_delay_{};
};

}  // namespace biss::decode
