// Positions that no axis can have: steps far beyond all others, and turns that do not follow the
// singleturn.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "biss/frame/format.hpp"
#include "decode/cycle.hpp"
#include "decode/times.hpp"

namespace biss::explain {

/// The number of times that something was seen, and the cycles.
struct Sightings {
  std::uint64_t count = 0;
  std::uint64_t first_cycle = 0;
  std::uint64_t last_cycle = 0;
  Picoseconds first_time{};

  void add(std::uint64_t cycle, Picoseconds time) { add({1, cycle, cycle, time}); }
  void add(const Sightings& other) {
    if (other.count == 0) return;
    if (count == 0 || other.first_cycle < first_cycle) {
      first_cycle = other.first_cycle;
      first_time = other.first_time;
    }
    last_cycle = count == 0 ? other.last_cycle : std::max(last_cycle, other.last_cycle);
    count += other.count;
  }
};

class Plausibility {
 public:
  /// Judges the positions of one channel.
  Plausibility(const FrameFormat& format, std::size_t channel)
      : number_(channel), channel_(format.channel_list[channel]) {}

  /// The next cycle.
  void push(std::uint64_t number, const decode::Cycle& cycle) {
    const unsigned bits = channel_.position_bits();
    if (!cycle.frame || bits == 0 || !cycle.frame->channel_list[number_].nE) {
      last_.reset();
      known_ = 0;
      late_by_ = 0;
      fall_.reset();
      return;
    }
    const std::uint64_t position = cycle.frame->channel_list[number_].position;
    ever_set_ |= position;
    const auto before = last_;
    last_ = position;
    const Picoseconds since = std::exchange(last_time_, cycle.time);
    if (!before) return;
    // After a rest, the axis may have made any number of turns.
    const Picoseconds interval = decode::elapsed(since, cycle.time);
    const bool rested = interval > 3 * std::exchange(interval_, interval);
    const unsigned turn_bits = channel_.multiturn.bits;
    const unsigned in_turn = bits - turn_bits;
    const std::int64_t whole = way(*before, position, bits);
    const auto judge = [&](std::int64_t moved) {
      const auto length = static_cast<std::uint64_t>(moved < 0 ? -moved : moved);
      const auto nanoseconds =
          static_cast<double>(std::max<std::int64_t>(interval.count / 1000, 1));
      const double speed = std::min(static_cast<double>(length) * 1e6 / nanoseconds, 1e18);
      judge_step({whole, length, static_cast<std::uint64_t>(speed), number, cycle.time});
    };
    if (rested) {
      late_by_ = 0;
      fall_.reset();
    }
    if (turn_bits == 0 || in_turn == 0 || in_turn > 62 || rested) {
      judge(whole);
      return;
    }
    const std::int64_t moved =
        way(*before & low_mask(in_turn), position & low_mask(in_turn), in_turn);
    const std::int64_t place = static_cast<std::int64_t>(*before & low_mask(in_turn)) + moved;
    const std::int64_t due = place < 0 ? -1 : place >> in_turn;
    const std::int64_t missing = due - way(*before >> in_turn, position >> in_turn, turn_bits);
    // The axis has jumped, or makes many turns between two frames.
    const bool jumped = missing > 1 || missing < -1;
    judge(jumped ? whole : moved);
    // A fast axis may have made more than half a turn.
    if (4 * (moved < 0 ? -moved : moved) > (std::int64_t{1} << in_turn)) {
      ++fast_steps_;
      late_by_ = 0;
      return;
    }
    ++slow_steps_;
    if (jumped) return;
    late_by_ += missing;
    fast_ = fast_ || late_by_ > 1 || late_by_ < -1;
    in_a_row_ = late_by_ == 0 ? 0 : in_a_row_ + 1;
    // The turns were wrong when the capture began, or have come to stay.
    constexpr std::uint64_t most_frames = 1000;
    if (in_a_row_ > most_frames) late_by_ = 0;
    if (late_by_ == 0) return;
    longest_ = std::max(longest_, in_a_row_);
    turns_.add(number, cycle.time);
  }

  /// Frames whose turns do not belong to their singleturn: by the turns of the format, or because
  /// the position has fallen back by a power of two, and continues from there.
  Sightings turns() const { return shows_falls() ? falls_ : turns_; }
  /// The longest time in a row for which they do not.
  std::uint64_t longest() const { return shows_falls() ? longest_fall_ : longest_; }
  /// Steps that are much longer than the fastest motion of the capture. After the last cycle.
  Sightings steps() const {
    Sightings seen;
    const std::size_t far = fastest(jumps_per_mille) + far_beyond;
    for (std::size_t bits = far; bits < apart_.size(); ++bits) seen.add(apart_[bits]);
    for (std::size_t width = 0; width < wraps_.size(); ++width) {
      // If no position needs more bits, the position wraps around.
      const bool round = static_cast<std::size_t>(std::bit_width(ever_set_)) < width;
      if (!round && wraps_[width].bits >= far) seen.add(wraps_[width].seen);
    }
    for (std::size_t bits = fastest(spikes_per_mille) + far_beyond; bits < spikes_.size(); ++bits) {
      seen.add(spikes_[bits]);
    }
    return seen;
  }

 private:
  // A step stands out if it is this many times as long as its neighbours, and longer than a few counts.
  static constexpr std::uint64_t times = 16;
  static constexpr std::uint64_t few_counts = 64;
  // The fastest motion: of the steps, these per mille are faster.
  static constexpr std::uint64_t jumps_per_mille = 30;
  static constexpr std::uint64_t spikes_per_mille = 350;
  // How much faster than that, in powers of two.
  static constexpr std::size_t far_beyond = 3;
  static constexpr std::size_t beyond = 2;

  // The shorter way from `from` to `to` on a ring of 2^bits.
  static std::int64_t way(std::uint64_t from, std::uint64_t to, unsigned bits) {
    const std::uint64_t up = (to - from) & low_mask(bits);
    const std::uint64_t down = (from - to) & low_mask(bits);
    return up <= down ? static_cast<std::int64_t>(up) : -static_cast<std::int64_t>(down);
  }

  // The power of two that this is nearly; 0 if there is none.
  static std::uint64_t power_near(std::uint64_t size) {
    const std::uint64_t power = std::bit_floor(size + size / 3);
    const std::uint64_t off = size < power ? power - size : size - power;
    return times * off > power ? 0 : power;
  }

  struct Step {
    std::int64_t way = 0;
    std::uint64_t length = 0;
    // In counts per millisecond.
    std::uint64_t speed = 0;
    std::uint64_t cycle = 0;
    Picoseconds time{};
  };

  // Since the position fell back by a power of two, against the motion.
  struct Fall {
    std::uint64_t size = 0;
    bool up = false;
    std::uint64_t cycle = 0;
    Picoseconds time{};
    // The step before.
    Step pace;
  };

  bool is_fast() const { return fast_ || 2 * fast_steps_ > slow_steps_; }
  bool shows_falls() const { return is_fast() || falls_.count > turns_.count; }
  // The number of bits of speed that this share of the steps, per mille, is faster than.
  std::size_t fastest(std::uint64_t per_mille) const {
    std::uint64_t sum = 0;
    for (const std::uint64_t count : all_) sum += count;
    std::size_t bits = all_.size();
    for (std::uint64_t above = 0; bits > 0; --bits) {
      above += all_[bits - 1];
      if (1000 * above > per_mille * sum) break;
    }
    return bits;
  }

  // Judges the last step but two.
  void judge_step(const Step& step) {
    std::copy_backward(steps_.begin(), steps_.end() - 1, steps_.end());
    steps_[0] = step;
    ++all_[static_cast<std::size_t>(std::bit_width(step.speed))];
    if (++known_ < steps_.size()) return;
    const Step& judged = steps_[2];
    if (judged.length < few_counts) return;
    // The step before may be the fall itself.
    const bool after_fall = fall_ && fall_->cycle == steps_[3].cycle;
    judge_turn(after_fall ? fall_->pace : steps_[3], judged);
    const auto bits = static_cast<std::size_t>(std::bit_width(judged.speed));
    const std::int64_t left = judged.way + steps_[1].way;
    const std::uint64_t taken_back = judged.length - judged.length / times;
    if (static_cast<std::uint64_t>(left < 0 ? -left : left) < judged.length / times &&
        steps_[1].length >= taken_back) {
      spikes_[bits].add(judged.cycle, judged.time);
    } else if (judged.speed / times > std::max(steps_[3].speed, steps_[1].speed)) {
      if (const std::uint64_t power = power_near(judged.length); power != 0) {
        Wrap& wrap = wraps_[static_cast<std::size_t>(std::bit_width(power))];
        wrap.seen.add(judged.cycle, judged.time);
        wrap.bits = std::max(wrap.bits, bits);
      } else {
        apart_[bits].add(judged.cycle, judged.time);
      }
    }
  }

  // If the turns are updated late, the position falls back at each zero of the singleturn and later
  // jumps ahead. A position that only wraps around never jumps ahead.
  void judge_turn(const Step& before, const Step& judged) {
    const std::int64_t jump = judged.way - before.way;
    const auto size = static_cast<std::uint64_t>(jump < 0 ? -jump : jump);
    const std::uint64_t power = power_near(size);
    constexpr std::uint64_t steps_in_turn = 6;
    if (before.way == 0 || size < steps_in_turn * before.length || power == 0) return;
    // Positions that jump about fall by a power of two now and then.
    const auto bits = static_cast<std::size_t>(std::bit_width(judged.speed));
    if (bits < fastest(spikes_per_mille) + beyond) return;
    const bool up = before.way > 0;
    if (up == (jump < 0)) {
      fall_ = {power, up, judged.cycle, judged.time, before};
    } else if (fall_ && fall_->size == power && fall_->up == up) {
      falls_.add({judged.cycle - fall_->cycle, fall_->cycle, judged.cycle - 1, fall_->time});
      longest_fall_ = std::max(longest_fall_, judged.cycle - fall_->cycle);
      fall_.reset();
    }
  }

  std::size_t number_;
  ChannelFormat channel_;
  std::optional<std::uint64_t> last_;
  Picoseconds last_time_{};
  Picoseconds interval_{INT64_MAX / 4};
  // By how many turns the counter is late.
  std::int64_t late_by_ = 0;
  // The axis makes whole turns between two frames, or more than a quarter of one.
  bool fast_ = false;
  std::uint64_t fast_steps_ = 0;
  std::uint64_t slow_steps_ = 0;
  std::uint64_t in_a_row_ = 0;
  std::uint64_t longest_ = 0;
  Sightings turns_;
  std::optional<Fall> fall_;
  Sightings falls_;
  std::uint64_t longest_fall_ = 0;
  // The last steps, the newest one first.
  std::array<Step, 4> steps_{};
  std::size_t known_ = 0;
  // By the number of bits of their speed: all steps, the steps that stand out from their
  // neighbours, and the outstanding steps that the next step takes back (spikes_).
  std::array<std::uint64_t, 65> all_{};
  std::array<Sightings, 65> apart_{};
  // Outstanding steps as long as the ring of a position with unused high bits, by their power of
  // two; and the bits of all positions.
  struct Wrap {
    Sightings seen;
    std::size_t bits = 0;
  };
  std::array<Wrap, 65> wraps_{};
  std::uint64_t ever_set_ = 0;
  std::array<Sightings, 65> spikes_{};
};

}  // namespace biss::explain
