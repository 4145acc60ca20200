// Positions that no axis can have: steps far beyond all others, and turns that do not follow the
// singleturn.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/frame/format.hpp"
#include "decode/cycle.hpp"
#include "explain/sightings.hpp"

namespace biss::explain {

class Plausibility {
 public:
  /// Judges the positions of one channel.
  Plausibility(const FrameFormat& format, std::size_t channel);

  /// The next cycle.
  void push(std::uint64_t number, const decode::Cycle& cycle);

  /// Frames whose turns do not belong to their singleturn: by the turns of the format, or because
  /// the position has fallen back by a power of two, and continues from there.
  Sightings turns() const { return shows_falls() ? falls_ : turns_; }
  /// The longest time in a row for which they do not.
  std::uint64_t longest() const { return shows_falls() ? longest_fall_ : longest_; }
  /// Steps that are much longer than the fastest motion of the capture. After the last cycle.
  Sightings steps() const;

 private:
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
  // The speed, in bits, that this share of the steps (per mille) exceeds.
  std::size_t fastest(std::uint64_t per_mille) const;
  void judge_step(const Step& step);
  void judge_turn(const Step& before, const Step& judged);

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
