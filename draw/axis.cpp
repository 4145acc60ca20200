// The axis of time of a drawing.
#include <algorithm>

#include "decode/times.hpp"
#include "draw/layout.hpp"

namespace biss::draw {

namespace {

using decode::LevelChange;
using decode::shifted;
using wire::Level;

// In periods: the part that stays on each side of a cut, and the shortest cut.
constexpr std::int64_t periods_kept = 3;
constexpr std::int64_t cut_periods_min = 6;

// A level of MA is not even if its length differs from the others by a period divided by this.
constexpr std::int64_t uneven_divisor = 4;

bool is_even(const CycleDrawing& drawing, const LevelChange& from, const LevelChange& to) {
  const Picoseconds period = drawing.period();
  const std::int64_t high = drawing.cycle.duty_per_mille.value_or(500);
  const std::int64_t share = from.level == Level::high ? high : 1000 - high;
  const Picoseconds off = decode::elapsed(from.time, to.time) - period * share / 1000;
  return uneven_divisor * std::max(off, -off) <= period;
}

// Times at which something happens, sorted.
std::vector<Picoseconds> events_of(const CycleDrawing& drawing, std::span<const Picoseconds> kept) {
  std::vector<Picoseconds> events{drawing.cycle.time, drawing.end};
  events.insert(events.end(), kept.begin(), kept.end());
  for (const LevelChange& change : drawing.slo) events.push_back(change.time);
  for (const DrawnBit& bit : drawing.bits) {
    if (bit.clock < 2) events.push_back(bit.time);
    if (bit.sampled_at && !bit.name.empty() && bit.name != "ACK") events.push_back(*bit.sampled_at);
  }
  const auto& ma = drawing.ma;
  for (std::size_t i = 1; i < ma.size(); ++i) {
    if (is_even(drawing, ma[i - 1], ma[i])) continue;
    events.push_back(ma[i - 1].time);
    events.push_back(ma[i].time);
  }
  if (!ma.empty()) events.push_back(ma.back().time);
  std::sort(events.begin(), events.end());
  return events;
}

std::size_t clocks_between(const CycleDrawing& drawing, Picoseconds from, Picoseconds to) {
  auto at = std::lower_bound(
      drawing.ma.begin(), drawing.ma.end(), from,
      [](const LevelChange& change, Picoseconds time) { return change.time < time; });
  std::size_t clocks = 0;
  for (; at != drawing.ma.end() && at->time < to; ++at)
    clocks += at->level == Level::high ? 1U : 0U;
  return clocks;
}

}  // namespace

std::vector<Cut> cuts_of(const CycleDrawing& drawing, std::span<const Picoseconds> kept) {
  std::vector<Cut> cuts;
  const Picoseconds period = drawing.period();
  const std::vector<Picoseconds> events = events_of(drawing, kept);
  for (std::size_t i = 1; i < events.size(); ++i) {
    const std::int64_t periods = decode::elapsed(events[i - 1], events[i]).count / period.count;
    const std::int64_t left_out = periods - 2 * periods_kept;
    if (left_out < cut_periods_min) continue;
    const Picoseconds from = shifted(events[i - 1], periods_kept * period);
    // Whole periods, unless the stretch is longer than elapsed() counts.
    const Picoseconds to = std::max(shifted(from, left_out * period),
                                    shifted(events[i], -(periods_kept + 1) * period));
    cuts.push_back({from, to, clocks_between(drawing, from, to)});
  }
  return cuts;
}

Axis::Axis(const CycleDrawing& drawing, const std::vector<Cut>& cuts, std::size_t clock_ticks,
           std::size_t cut_clocks)
    : period_(std::max(drawing.period(), picoseconds(1))),
      clock_ticks_(clock_ticks),
      cut_ticks_(cut_clocks * clock_ticks) {
  const std::size_t ticks_max = static_cast<std::size_t>(clocks_max) * clock_ticks;
  Picoseconds from = shifted(drawing.cycle.time, -(period_ / 2));
  std::size_t first = 0;
  const auto add = [&](Picoseconds to) {
    const auto width = static_cast<std::size_t>(ticks_of(from, std::max(from, to)));
    truncated_ = truncated_ || first + width > ticks_max;
    pieces_.push_back({from, to, first, std::min(first + width, ticks_max)});
  };
  for (const Cut& cut : cuts) {
    add(cut.from);
    if (truncated_) return;
    first = pieces_.back().last + cut_ticks_;
    from = cut.to;
  }
  add(drawing.end);
}

std::int64_t Axis::ticks_of(Picoseconds from, Picoseconds to) const {
  const std::int64_t gap = decode::elapsed(from, to).count;
  const auto per_clock = static_cast<std::int64_t>(clock_ticks_);
  const std::int64_t clocks = gap / period_.count;
  if (clocks > 2 * clocks_max) return 2 * clocks_max * per_clock;
  // A gap is an hour at most, so that the product fits.
  return clocks * per_clock + gap % period_.count * per_clock / period_.count;
}

std::size_t Axis::at(Picoseconds time) const {
  for (const Piece& piece : pieces_) {
    if (time > piece.to && &piece != &pieces_.back()) continue;
    if (time < piece.from) return piece.first == 0 ? 0 : piece.first - cut_ticks_;
    return std::min(piece.last, piece.first + static_cast<std::size_t>(ticks_of(piece.from, time)));
  }
  return ticks();
}

bool Axis::shows(Picoseconds time) const {
  if (truncated_ && at(time) >= ticks()) return false;
  for (const Piece& piece : pieces_) {
    if (time >= piece.from && time <= piece.to) return true;
  }
  return false;
}

}  // namespace biss::draw
