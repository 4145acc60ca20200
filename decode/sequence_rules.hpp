// Rules on how requests and frames follow one another, and on nE, nW and the sign of life.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "decode/check.hpp"
#include "decode/times.hpp"

namespace biss::decode {

/// Finds requests that are missing in a regular sequence.
class RequestGaps {
 public:
  /// Takes the next interval. \return how many requests are missing in the previous interval; empty
  ///   if that is unknown, because the requests do not come at one rate
  std::optional<std::uint64_t> push(Picoseconds interval, Picoseconds doubt) {
    const bool known = usual_count_ >= needed;
    if (usual_count_ != 0 && is_near(interval, usual_, doubt)) {
      // Only between requests at the same rate a gap is certain.
      const std::uint64_t missing = gap_.value_or(0);
      gap_.reset();
      usual_count_ = std::min(usual_count_ + 1, needed);
      return known ? std::optional(missing) : std::nullopt;
    }
    const std::int64_t times = known ? periods_in(interval, usual_) : 0;
    if (times >= 2 && times <= most_times && is_near(interval, times * usual_, doubt) && !gap_) {
      gap_ = static_cast<std::uint64_t>(times - 1);
      return std::nullopt;
    }
    gap_.reset();
    usual_ = std::max(interval, picoseconds(1));
    usual_count_ = 1;
    return std::nullopt;
  }

  void reset() { usual_count_ = 0, gap_.reset(); }

 private:
  bool is_near(Picoseconds interval, Picoseconds expected, Picoseconds doubt) const {
    const Picoseconds off = interval - expected;
    return std::max(off, -off) <= usual_ / same_share + doubt;
  }

  // An interval within this share of another one is the same.
  static constexpr std::int64_t same_share = 50;
  // Equal intervals in a row that make a rate.
  static constexpr unsigned needed = 4;
  // A longer interval is a pause of the master.
  static constexpr std::int64_t most_times = 10;

  Picoseconds usual_{};
  unsigned usual_count_ = 0;
  // The previous interval as a multiple of the usual one, if it is one.
  std::optional<std::uint64_t> gap_;
};

class SequenceRules {
 public:
  SequenceRules(const CheckSetup& setup, Tallies& tallies)
      : format_(setup.format),
        sampling_spread_(setup.timing.sampling_max - setup.timing.sampling_min),
        speed_max_(std::min(setup.speed_max, most_speed)),
        tallies_(tallies),
        counts_to_63_(setup.renishaw_cables) {
    tallies_.make_advice(Rule::nW);
    tallies_.make_advice(Rule::counter_values);
    if (counts_to_63_) return;
    tallies_.explain(Rule::counter_values, "the values of the sign of life are not known");
  }

  void push(std::uint64_t number, const Cycle& cycle) {
    judge_interval(number, cycle);
    if (!cycle.frame || !format_) {
      last_frame_.reset();
      return;
    }
    const Frame& frame = *cycle.frame;
    judge_flags(number, frame);
    if (last_frame_) judge_life(number, frame);
    judge_speed(number, cycle, frame);
    last_frame_ = frame;
  }

 private:
  // A speed is not above this.
  static constexpr std::uint64_t most_speed = std::uint64_t{1} << 52U;

  // Counts per second, rounded down.
  static std::uint64_t speed_of(std::uint64_t counts, Picoseconds time) {
    const double speed = static_cast<double>(counts) * static_cast<double>(picoseconds_per_second) /
                         static_cast<double>(time.count);
    return speed < static_cast<double>(most_speed) ? static_cast<std::uint64_t>(speed) : most_speed;
  }

  void judge_interval(std::uint64_t number, const Cycle& cycle) {
    if (cycle.status == CycleStatus::ma_glitch) return;
    const auto before = last_request_;
    last_request_.reset();
    if (is_cut(cycle.status) || cycle.status == CycleStatus::unknown_level) return gaps_.reset();
    last_request_ = cycle.time;
    if (!before) return;
    const auto missing = gaps_.push(elapsed(*before, cycle.time), 2 * tallies_.resolution());
    if (missing) {
      tallies_.count(Rule::missing_request, *missing == 0, last_number_,
                     "the next request is missing");
      if (*missing > 1) tallies_.add_faults(Rule::missing_request, *missing - 1, last_number_);
    }
    last_number_ = number;
  }

  void judge_flags(std::uint64_t number, const Frame& frame) {
    const auto formats = format_->channels();
    const auto channels = frame.channels();
    const auto judge = [&](Rule rule, auto present, auto good, std::string_view note) {
      bool has = false;
      bool all = true;
      for (std::size_t k = 0; k < formats.size() && k < channels.size(); ++k) {
        has = has || present(formats[k]);
        all = all && good(channels[k]);
      }
      if (has) tallies_.count(rule, all, number, note);
    };
    judge(
        Rule::nE, [](const ChannelFormat& format) { return format.error.present; },
        [](const auto& channel) { return channel.nE; }, "the encoder reports an error");
    judge(
        Rule::nW, [](const ChannelFormat& format) { return format.warning.present; },
        [](const auto& channel) { return channel.nW; }, "the encoder reports a warning");
  }

  // With each frame the sign of life is one more; after the last value comes 0 or 1.
  void judge_life(std::uint64_t number, const Frame& frame) {
    const auto formats = format_->channels();
    for (std::size_t k = 0; k < formats.size(); ++k) {
      const unsigned bits = formats[k].life_counter.bits;
      if (bits == 0) continue;
      const std::uint64_t last = last_frame_->channels()[k].life_counter;
      const std::uint64_t next = frame.channels()[k].life_counter;
      const bool wraps = last == low_mask(bits) && next <= 1;
      tallies_.count(Rule::sign_of_life, wraps || next == last + 1, number,
                     "the sign of life is not one more than before");
      if (wraps && bits == 6 && counts_to_63_) {
        tallies_.count(Rule::counter_values, next == 1, number,
                       "the sign of life has 64 values: after 63 comes 0");
      }
    }
  }

  // The shorter way is the least that the encoder has moved.
  void judge_speed(std::uint64_t number, const Cycle& cycle, const Frame& frame) {
    const unsigned bits = format_->channels().front().position_bits();
    if (speed_max_ == 0 || bits == 0) return;
    const std::uint64_t position = frame.channels().front().position;
    const auto before = last_position_;
    const Picoseconds since = before ? elapsed(position_time_, cycle.time) : Picoseconds{};
    last_position_ = position;
    position_time_ = cycle.time;
    if (since <= Picoseconds{}) return;
    // The shorter way on the ring of positions.
    const std::uint64_t moved =
        std::min((position - *before) & low_mask(bits), (*before - position) & low_mask(bits));
    // One count is the noise of a position that is rounded.
    const Picoseconds longest = since + sampling_spread_ + 2 * tallies_.resolution();
    const auto seen = static_cast<std::int64_t>(speed_of(moved, since));
    const auto least =
        static_cast<std::int64_t>(speed_of(moved - std::min<std::uint64_t>(moved, 1), longest));
    const auto limit = static_cast<std::int64_t>(speed_max_);
    tallies_.measure(Rule::speed, {1'000 * limit, 1'000 * seen, 1'000 * (limit - seen)},
                     1'000 * (seen - least), number);
  }

  std::optional<FrameFormat> format_;
  // The sampling moment of the position varies by this much from frame to frame.
  Picoseconds sampling_spread_;
  std::uint64_t speed_max_;
  Tallies& tallies_;
  // The data sheet names 63 values of the sign of life.
  bool counts_to_63_;
  RequestGaps gaps_;
  std::optional<Picoseconds> last_request_;
  std::uint64_t last_number_ = 0;
  // The frame of the previous cycle, if it was good.
  std::optional<Frame> last_frame_;
  // The position of the last good cycle.
  std::optional<std::uint64_t> last_position_;
  Picoseconds position_time_{};
};

}  // namespace biss::decode
