// The axis of time of a drawing: the place of each time, and the stretches that are cut out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "draw/cycle_drawing.hpp"

namespace biss::draw {

/// A stretch of time that is not drawn, because nothing changes in it but an even MA.
struct Cut {
  Picoseconds from{};
  Picoseconds to{};
  /// Rising edges of MA in it.
  std::size_t clocks = 0;
};

/// The stretches of a drawing that can be left out: a long ACK, extra clocks, a long timeout. A few
/// periods before and after each change stay, and a few around the times in `kept`.
std::vector<Cut> cuts_of(const CycleDrawing& drawing, std::span<const Picoseconds> kept = {});

/// The places of times, in ticks from the left. Only integers, so that every machine has the same
/// result.
class Axis {
 public:
  /// Half a clock is drawn before the cycle.
  /// \param clock_ticks of a period; even
  /// \param cut_clocks  width of a cut in clocks
  Axis(const CycleDrawing& drawing, const std::vector<Cut>& cuts, std::size_t clock_ticks,
       std::size_t cut_clocks);

  /// The tick of a time; within a cut the tick of the cut's beginning. At most ticks().
  std::size_t at(Picoseconds time) const;
  /// False within a cut, and after the end of the drawing.
  bool shows(Picoseconds time) const;
  /// The tick at which a cut begins.
  std::size_t cut_at(std::size_t cut) const { return pieces_[cut].last; }

  std::size_t ticks() const { return pieces_.back().last; }
  std::size_t clock_ticks() const { return clock_ticks_; }
  std::size_t cut_ticks() const { return cut_ticks_; }
  /// The cycle has more clocks than a drawing can hold.
  bool truncated() const { return truncated_; }

 private:
  // From one cut to the next.
  struct Piece {
    Picoseconds from{};
    Picoseconds to{};
    std::size_t first = 0;
    std::size_t last = 0;
  };
  // The longest request has about 700 clocks.
  static constexpr std::int64_t clocks_max = 1365;

  std::int64_t ticks_of(Picoseconds from, Picoseconds to) const;

  Picoseconds period_;
  std::size_t clock_ticks_;
  std::size_t cut_ticks_;
  std::vector<Piece> pieces_;
  bool truncated_ = false;
};

}  // namespace biss::draw
