#include "decode/clean_measure.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <type_traits>

// The levels between gain too little for the time that they take to compile.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "decode/clean_measure.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "decode/cycle_rules.hpp"
#include "decode/times.hpp"

HWY_BEFORE_NAMESPACE();
namespace biss::decode::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::ScalableTag<std::int32_t>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;

// Edges and changes later than this belong to another cycle; sums of two times fit 32 bits.
constexpr std::int32_t far = 1'600'000'000;
constexpr std::int32_t longest_cycle = 500'000'000;
// Sums of the offsets of all changes fit 32 bits.
constexpr std::int32_t longest_period = 2'000'000;
constexpr std::size_t least_edges = 16;
constexpr std::int32_t none = std::numeric_limits<std::int32_t>::max();

using Times = CleanScratch::Times;

static_assert(std::endian::native == std::endian::little,
              "convert() takes the first half of a time");

// The times of a capture may be further apart than 64 bits can hold. \pre time >= begin
inline std::int64_t since(std::int64_t begin, std::int64_t time) {
  return elapsed(Picoseconds{begin}, Picoseconds{time}).count;
}
inline std::int32_t after(std::int64_t time, std::int64_t begin) {
  return static_cast<std::int32_t>(std::min<std::int64_t>(since(begin, time), far));
}

HWY_INLINE M first_lanes(std::size_t count) {
  const D d;
  return hn::FirstN(d, std::min(count, hn::Lanes(d)));
}

// 0, 1, 2, … for each lane. hn::Iota() stores and loads them each time.
HWY_INLINE V first_numbers() {
  alignas(64) static constexpr std::int32_t numbers[16] = {0, 1, 2,  3,  4,  5,  6,  7,
                                                           8, 9, 10, 11, 12, 13, 14, 15};
  static_assert(hn::MaxLanes(D()) <= 16);
  return hn::Load(D(), numbers);
}

struct TakeLeast {
  static constexpr std::int32_t nothing = none;

  template <class Vector>
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return hn::Min(a, b);
  }
};
struct TakeSum {
  static constexpr std::int32_t nothing = 0;

  template <class Vector>
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return hn::Add(a, b);
  }
};

#if HWY_TARGET != HWY_SCALAR
struct TakeDifference {
  template <class Vector>
  HWY_INLINE Vector operator()(Vector a, Vector b) const {
    return hn::Xor(a, b);
  }
};

// Halves the vector until it has 16 bytes.
template <class Tag, class Fold>
HWY_INLINE auto fold_to_block(Tag tag, hn::Vec<Tag> v, Fold fold) {
  if constexpr (hn::MaxLanes(tag) * sizeof(hn::TFromD<Tag>) <= 16) {
    return v;
  } else {
    const hn::Half<Tag> half;
    return fold_to_block(half, fold(hn::LowerHalf(half, v), hn::UpperHalf(half, v)), fold);
  }
}

// Folds two vectors in one step: `a` into the lower half, `b` into the upper half. Even and odd
// lanes stay separate.
template <class Tag, class Fold>
HWY_INLINE auto fold_both(Tag tag, hn::Vec<Tag> a, hn::Vec<Tag> b, Fold fold) {
  const hn::CappedTag<hn::TFromD<Tag>, 16 / sizeof(hn::TFromD<Tag>)> block;
  const auto low = fold_to_block(tag, a, fold);
  const auto high = fold_to_block(tag, b, fold);
  return fold(hn::ConcatLowerLower(block, high, low), hn::ConcatUpperUpper(block, high, low));
}
#endif

// Two vectors, each folded to its even lanes and its odd ones.
template <class Fold>
struct Folded {
  alignas(16) std::array<std::int32_t, 4> lanes;

  HWY_INLINE Folded(V a, V b) {
#if HWY_TARGET == HWY_SCALAR
    lanes = {hn::GetLane(a), Fold::nothing, hn::GetLane(b), Fold::nothing};
#else
    hn::Store(fold_both(D(), a, b, Fold()), hn::CappedTag<std::int32_t, 4>(), lanes.data());
#endif
  }
  HWY_INLINE std::int32_t first() const { return both(lanes[0], lanes[1]); }
  HWY_INLINE std::int32_t second() const { return both(lanes[2], lanes[3]); }

 private:
  static HWY_INLINE std::int32_t both(std::int32_t a, std::int32_t b) {
    if constexpr (std::is_same_v<Fold, TakeSum>) return a + b;
    return std::min(a, b);
  }
};

// times[i] - begin for whole vectors from the third time on, up to the first one that is `far` or
// more: such times become `far`. `done` gets the index, the new times, and their distances from the
// previous times and from the times two before; a distance is valid if both times are below `far`.
// \return the end of the converted times. \pre there are two times
template <class Done>
HWY_INLINE std::size_t convert(std::span<const std::int64_t> times, std::int64_t begin, Times& out,
                               Done done) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  const std::size_t count = std::min(times.size(), CleanScratch::max_edges);
  const V base = hn::Set(d, static_cast<std::int32_t>(static_cast<std::uint64_t>(begin)));
  // Only the lower halves of the times are needed.
  const auto low_halves = [&](std::size_t i) HWY_ATTR {
    V low;
    V high;
    hn::LoadInterleaved2(d, reinterpret_cast<const std::int32_t*>(times.data() + i), low, high);
    return low;
  };
  out[0] = after(times[0], begin);
  out[1] = after(times[1], begin);
  std::size_t i = 2;
  for (; i + lanes <= count && since(begin, times[i + lanes - 1]) < far; i += lanes) {
    const V low = low_halves(i);
    const V now = hn::Sub(low, base);
    hn::StoreU(now, d, out.data() + i);
    if (done(i, i + lanes, now, hn::Sub(low, low_halves(i - 1)), hn::Sub(low, low_halves(i - 2)))) {
      return i + lanes;
    }
  }
  // The remaining times, one by one: the end of the array, or the last ones before a long pause.
  const std::size_t end = std::min(i + lanes, count);
  for (std::size_t k = i; k < end; ++k) out[k] = after(times[k], begin);
  if (i < end) {
    const V now = hn::LoadU(d, out.data() + i);
    done(i, end, now, hn::Sub(now, hn::LoadU(d, out.data() + i - 1)),
         hn::Sub(now, hn::LoadU(d, out.data() + i - 2)));
  }
  return end;
}

// The clock on MA, from the edges up to the first long gap.
struct Clock {
  std::int32_t longest_gap = 0;
  // Among the gaps from which the decoder detects a pause.
  std::int32_t longest_of_first = 0;
  std::int32_t rise_least = 0;
  std::int32_t rise_most = 0;
  std::int32_t fall_least = 0;
  std::int32_t fall_most = 0;
  std::int32_t high = 0;
};

// The longest of the gaps from which the decoder detects a pause.
HWY_INLINE V gaps_at_begin(const Times& edges) {
  const D d;
  V longest = hn::Zero(d);
  for (std::size_t i = 1; i < lookahead_edges; i += hn::Lanes(d)) {
    const V gaps = hn::Sub(hn::LoadU(d, edges.data() + i), hn::LoadU(d, edges.data() + i - 1));
    longest = hn::Max(longest, hn::IfThenElseZero(first_lanes(lookahead_edges - i), gaps));
  }
  return longest;
}

// Adds up a Clock from the edges after the first two.
#if HWY_TARGET == HWY_SCALAR
class ClockSums {
 public:
  void add(V, V) {}
  void add(V, V, M) {}

  Clock get(const Times& edges, std::size_t count) const {
    Clock clock{.longest_gap = edges[1],
                .longest_of_first = hn::GetLane(gaps_at_begin(edges)),
                .rise_least = none,
                .fall_least = none};
    for (std::size_t i = 2; i < count; ++i) {
      const std::int32_t gap = edges[i] - edges[i - 1];
      const std::int32_t step = edges[i] - edges[i - 2];
      const bool falls = i % 2 == 0;
      std::int32_t& least = falls ? clock.fall_least : clock.rise_least;
      std::int32_t& most = falls ? clock.fall_most : clock.rise_most;
      least = std::min(least, step);
      most = std::max(most, step);
      clock.longest_gap = std::max(clock.longest_gap, gap);
      if (falls) clock.high += gap;
    }
    return clock;
  }
};
#else
// Falls have even indices, and so even lanes. A maximum is computed as the minimum of the negated
// values.
class ClockSums {
 public:
  HWY_INLINE ClockSums()
      : least_step_(hn::Set(D(), none)),
        most_step_(hn::Zero(D())),
        most_gap_(hn::Zero(D())),
        sum_(hn::Zero(D())) {}

  HWY_INLINE void add(V gaps, V steps) { add(gaps, steps, steps); }
  HWY_INLINE void add(V gaps, V steps, M valid) {
    const D d;
    add(hn::IfThenElseZero(valid, gaps), hn::IfThenElse(valid, steps, hn::Set(d, none)),
        hn::IfThenElseZero(valid, steps));
  }

  HWY_INLINE Clock get(const Times& edges, std::size_t) const {
    const D d;
    const Folded<TakeLeast> steps(least_step_, hn::Neg(most_step_));
    const Folded<TakeLeast> gaps(hn::Neg(most_gap_), hn::Neg(gaps_at_begin(edges)));
    const Folded<TakeSum> sums(sum_, hn::Zero(d));
    return {.longest_gap = std::max(-gaps.first(), edges[1]),
            .longest_of_first = -gaps.second(),
            .rise_least = steps.lanes[1],
            .rise_most = -steps.lanes[3],
            .fall_least = steps.lanes[0],
            .fall_most = -steps.lanes[2],
            .high = sums.lanes[0]};
  }

 private:
  HWY_INLINE void add(V gaps, V steps, V steps_or_zero) {
    least_step_ = hn::Min(least_step_, steps);
    most_step_ = hn::Max(most_step_, steps_or_zero);
    most_gap_ = hn::Max(most_gap_, gaps);
    sum_ = hn::Add(sum_, gaps);
  }

  V least_step_;
  V most_step_;
  V most_gap_;
  V sum_;
};
#endif

HWY_INLINE V rises_from(const Times& edges, std::size_t index) {
  V fall;
  V rise;
  hn::LoadInterleaved2(D(), edges.data() + 2 * index, fall, rise);
  return rise;
}

// Every second edge rises, the second one first.
HWY_INLINE V gather_rises(const std::int32_t* edges, V index) {
  return hn::GatherIndex(D(), edges + 1, hn::Add(index, index));
}

HWY_INLINE std::int32_t clock_change(const Times& edges, std::size_t count) {
  const D d;
  std::int32_t change = 0;
  for (std::size_t apart = 1; apart <= 8 && apart < count; apart *= 2) {
    V shortest = hn::Set(d, none);
    V longest = hn::Zero(d);
    for (std::size_t i = 0; i + apart < count; i += hn::Lanes(d)) {
      const V time = hn::Sub(rises_from(edges, i + apart), rises_from(edges, i));
      const M valid = first_lanes(count - apart - i);
      shortest = hn::Min(shortest, hn::IfThenElse(valid, time, hn::Set(d, none)));
      longest = hn::Max(longest, hn::IfThenElseZero(valid, time));
    }
    const Folded<TakeLeast> both(shortest, hn::Neg(longest));
    change = std::max(change, -both.second() - both.first());
  }
  return change;
}

// Rising edges as measured, and rising edges of an even clock, which are computed and not looked
// up.
#if HWY_TARGET <= HWY_AVX3
// The edges of most cycles fit four registers, in which a look-up is much faster.
class Measured {
 public:
  Measured(const Times& edges, std::int32_t count)
      : edges_(edges.data()), in_registers_(count <= 64) {
    if (!in_registers_) return;
    for (std::size_t k = 0; k < 4; ++k) tables_[k] = rises_from(edges, 16 * k);
  }

  HWY_INLINE void edges_at(V index, V& edge, V& before) const {
    const V index_before = hn::Sub(index, hn::Set(D(), 1));
    if (HWY_LIKELY(in_registers_)) {
      edge = look_up(index);
      before = look_up(index_before);
    } else {
      edge = gather_rises(edges_, index);
      before = gather_rises(edges_, index_before);
    }
  }

 private:
  HWY_INLINE V look_up(V index) const {
    const D d;
    const auto place = hn::IndicesFromVec(d, hn::And(index, hn::Set(d, 15)));
    const M odd = hn::TestBit(index, hn::Set(d, 16));
    const auto of_two = [&](V even_table, V odd_table) HWY_ATTR {
      return hn::IfThenElse(odd, hn::TableLookupLanes(odd_table, place),
                            hn::TableLookupLanes(even_table, place));
    };
    return hn::IfThenElse(hn::TestBit(index, hn::Set(d, 32)), of_two(tables_[2], tables_[3]),
                          of_two(tables_[0], tables_[1]));
  }

  const std::int32_t* edges_;
  bool in_registers_;
  V tables_[4];
};
#else
class Measured {
 public:
  Measured(const Times& edges, std::int32_t) : edges_(edges.data()) {}

  HWY_INLINE void edges_at(V index, V& edge, V& before) const {
    edge = gather_rises(edges_, index);
    before = gather_rises(edges_, hn::Sub(index, hn::Set(D(), 1)));
  }

 private:
  const std::int32_t* edges_;
};
#endif
struct Even {
  std::int32_t begin;
  std::int32_t period;

  HWY_INLINE void edges_at(V index, V& edge, V& before) const {
    const V step = hn::Set(D(), period);
    edge = hn::Add(hn::Set(D(), begin), hn::Mul(index, step));
    before = hn::Sub(edge, step);
  }
};

// A clock and how far it is moved.
template <class Rises>
struct Grid {
  Rises rises;
  std::int32_t count;
  std::int32_t second;
  std::int32_t shift;
  float per_period;

  // For each change the first edge that is not before it, from 1 to `count`, and the edge before
  // that. False if they are not found in a few steps: the clock is not even enough.
  HWY_INLINE bool find(V change, V& index, V& edge, V& edge_before) const {
    const D d;
    const hn::Rebind<float, D> df;
    const V one = hn::Set(d, 1);
    const V end = hn::Set(d, count);
    const V moved = hn::Sub(change, hn::Set(d, shift));
    const V from_second = hn::Sub(moved, hn::Set(d, second));
    // Nearly always right.
    const auto place =
        hn::MulAdd(hn::ConvertTo(df, from_second), hn::Set(df, per_period), hn::Set(df, 0.5F));
    index = hn::Min(hn::Max(hn::Add(hn::NearestInt(place), one), one), end);
    for (int i = 0; i < 4; ++i) {
      rises.edges_at(index, edge, edge_before);
      const M later = hn::And(hn::Lt(edge, moved), hn::Lt(index, end));
      const M earlier = hn::And(hn::Gt(hn::Add(edge_before, one), moved), hn::Gt(index, one));
      if (hn::AllFalse(d, hn::Or(later, earlier))) return true;
      index = hn::Add(index, hn::IfThenElseZero(later, one));
      index = hn::Sub(index, hn::IfThenElseZero(earlier, one));
    }
    return false;
  }

  // The same, starting from the result for another shift.
  HWY_INLINE bool confirm(V change, V& index, V& edge, V& edge_before) const {
    const D d;
    const V one = hn::Set(d, 1);
    const V moved = hn::Sub(change, hn::Set(d, shift));
    const M later = hn::And(hn::Lt(edge, moved), hn::Lt(index, hn::Set(d, count)));
    const M earlier = hn::And(hn::Gt(hn::Add(edge_before, one), moved), hn::Gt(index, one));
    if (hn::AllFalse(d, hn::Or(later, earlier))) return true;
    return find(change, index, edge, edge_before);
  }
};

struct Delay {
  std::int32_t mean = 0;
  std::int32_t spread = 0;
};

// From an edge of the clock to SLO's change, averaged over the cycle. `keep` gets the result for
// each vector of changes.
template <class Rises, class Keep>
HWY_INLINE bool delay_from(const Rises& rises, std::int32_t second, const CleanMeasure& m,
                           float per_period, const Times& changes, Delay& delay, Keep keep) {
  const D d;
  const std::int32_t first = changes[0] - second;
  const std::int32_t half = m.period / 2;
  const auto rise_count = static_cast<std::int32_t>(m.rises);
  const Grid<Rises> grid{rises, rise_count, second, first + half, per_period};
  V sum = hn::Zero(d);
  V least = hn::Zero(d);
  V most = hn::Zero(d);
  std::size_t valid_count = 0;
  // The change that makes ACK has the offset 0, and counts.
  for (std::size_t i = 0; i < m.changes; i += hn::Lanes(d)) {
    const V change = hn::LoadU(d, changes.data() + i);
    V index;
    V edge;
    V edge_before;
    if (!grid.find(change, index, edge, edge_before)) return false;
    keep(i, index, edge, edge_before);
    const V off = hn::Sub(hn::Sub(change, edge), hn::Set(d, first));
    const M valid =
        hn::And(hn::And(first_lanes(m.changes - i), hn::Lt(index, hn::Set(d, rise_count))),
                hn::Gt(off, hn::Set(d, -half - 1)));
    const V counted = hn::IfThenElseZero(valid, off);
    sum = hn::Add(sum, counted);
    least = hn::Min(least, counted);
    most = hn::Max(most, counted);
    valid_count += hn::CountTrue(d, valid);
  }
  const Folded<TakeSum> sums(sum, hn::Zero(d));
  const Folded<TakeLeast> bounds(least, hn::Neg(most));
  delay.mean = first + sums.first() / static_cast<std::int32_t>(valid_count);
  delay.spread = -bounds.second() - bounds.first();
  return true;
}

// The beginning of the even clock that fits best; false if the clock is not even.
HWY_INLINE bool lay_even_clock(const Times& edges, std::int32_t count, std::int32_t period,
                               std::int32_t& begin) {
  const D d;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  const V step = hn::Set(d, period);
  const V half = hn::Set(d, period / 2);
  V sum = hn::Zero(d);
  M uneven = hn::FirstN(d, 0);
  V place = hn::Add(hn::Set(d, edges[1]), hn::Mul(first_numbers(), step));
  const V next = hn::Set(d, lanes * period);
  for (std::int32_t i = 0; i < count; i += lanes, place = hn::Add(place, next)) {
    const auto at = static_cast<std::size_t>(i);
    const V off = hn::IfThenElseZero(first_lanes(static_cast<std::size_t>(count - i)),
                                     hn::Sub(rises_from(edges, at), place));
    // For whole numbers, 2 * off > period if off > period / 2.
    uneven = hn::Or(uneven, hn::Gt(hn::Abs(off), half));
    sum = hn::Add(sum, off);
  }
  begin = edges[1] + hn::GetLane(hn::SumOfLanes(d, sum)) / count;
  return hn::AllFalse(d, uneven);
}

// `sampling_delay` of CycleReader. The look-ups on the measured clock stay in `scratch`.
HWY_INLINE bool measure_delay(const Clock& clock, const Measured& rises, float per_period,
                              CleanScratch& scratch, CleanMeasure& m) {
  const D d;
  const auto keep = [&](std::size_t i, V index, V edge, V edge_before) HWY_ATTR {
    hn::StoreU(index, d, scratch.samples.data() + i);
    hn::StoreU(edge, d, scratch.found.data() + i);
    hn::StoreU(edge_before, d, scratch.found_before.data() + i);
  };
  const std::int32_t first = scratch.edges[1];
  const Times& changes = scratch.changes;
  Delay seen;
  const bool exact = clock.rise_least == clock.rise_most;
  const bool found =
      exact ? delay_from(Even{first, m.period}, m.second_rise, m, per_period, changes, seen, keep)
            : delay_from(rises, m.second_rise, m, per_period, changes, seen, keep);
  if (!found) return false;
  m.delay = seen.mean;
  std::int32_t begin = 0;
  if (8 * seen.spread <= m.period ||
      !lay_even_clock(scratch.edges, static_cast<std::int32_t>(m.rises), m.period, begin)) {
    return true;
  }
  Delay even;
  const auto drop = [](std::size_t, V, V, V) HWY_ATTR {};
  if (!delay_from(Even{begin, m.period}, begin + m.period, m, per_period, changes, even, drop)) {
    return false;
  }
  if (even.spread < seen.spread) m.delay = even.mean;
  return true;
}

// For each change of SLO the first sample after it, and the first sample that is close.
HWY_INLINE bool place_samples(const Measured& rises, float per_period, std::int32_t margin,
                              CleanScratch& scratch, CleanMeasure& m) {
  const D d;
  const auto rise_count = static_cast<std::int32_t>(m.rises);
  const std::int32_t shift = m.delay + m.period / 2;
  const Grid<Measured> grid{rises, rise_count, m.second_rise, shift, per_period};
  const V one = hn::Set(d, 1);
  const V nothing = hn::Set(d, none);
  const V too_far = hn::Set(d, margin + 1);
  V marginal = nothing;
  for (std::size_t i = 0; i < m.changes; i += hn::Lanes(d)) {
    V index = hn::LoadU(d, scratch.samples.data() + i);
    V edge = hn::LoadU(d, scratch.found.data() + i);
    V edge_before = hn::LoadU(d, scratch.found_before.data() + i);
    const V change = hn::LoadU(d, scratch.changes.data() + i);
    if (!grid.confirm(change, index, edge, edge_before)) return false;
    const M valid = first_lanes(m.changes - i);
    hn::StoreU(hn::IfThenElse(valid, index, nothing), d, scratch.samples.data() + i);
    const V moved = hn::Sub(change, hn::Set(d, shift));
    const M just_after = hn::And(hn::Lt(hn::Sub(moved, edge_before), too_far), hn::Gt(index, one));
    const M just_before =
        hn::And(hn::Lt(hn::Sub(edge, moved), too_far), hn::Lt(index, hn::Set(d, rise_count)));
    const V close = hn::IfThenElse(just_after, hn::Sub(index, one),
                                   hn::IfThenElse(just_before, index, nothing));
    marginal = hn::Min(marginal, hn::IfThenElse(valid, close, nothing));
  }
  m.first_marginal = hn::GetLane(hn::MinOfLanes(d, marginal));
  return true;
}

// Gaps that are a little longer than those at the beginning, in their order: may the encoder have
// become idle in one? Then the last change of SLO in it would be a rise, and SLO would be high at
// the next falling edge.
class Pauses {
 public:
  Pauses(const CleanScratch& scratch, const CleanMeasure& m, std::int32_t moved)
      : scratch_(scratch), changes_(m.changes), moved_(moved) {}

  bool may_be(std::size_t edge) {
    const std::int32_t last = scratch_.edges[edge - 1];
    const std::int32_t here = scratch_.edges[edge];
    const std::int32_t fall = edge % 2 == 0 ? here : scratch_.edges[edge + 1];
    // A change at the time of the next request belongs to that request.
    const auto later = [&](std::int32_t change) { return change > here || change >= fall; };
    next_ = first(next_, later);
    if (next_ == 0 || next_ % 2 != 0) return false;
    const std::int32_t rise = scratch_.changes[next_ - 1];
    if (rise <= last + moved_ || rise >= here) return false;
    return first(next_, [&](std::int32_t change) { return change >= fall; }) % 2 == 0;
  }

 private:
  template <class Condition>
  std::size_t first(std::size_t from, Condition condition) const {
    while (from < changes_ && !condition(scratch_.changes[from])) ++from;
    return from;
  }

  const CleanScratch& scratch_;
  std::size_t changes_;
  // After the last edge, SLO may still be moved by it.
  std::int32_t moved_;
  // The first change of SLO after the last gap.
  std::size_t next_ = 0;
};

HWY_INLINE bool has_pause(const CleanScratch& scratch, const CleanMeasure& m, const Clock& clock) {
  // The decoder's pause is at least this long.
  const std::int32_t pause = clock.longest_of_first + std::min(clock.rise_least, clock.fall_least) /
                                                          static_cast<std::int32_t>(pause_share);
  const std::int32_t moved = std::max(0, m.fall - m.second_rise) + clock.rise_least / 4;
  if (clock.longest_gap <= std::max(pause, moved)) return false;
  const D d;
  const V limit = hn::Set(d, pause);
  Pauses pauses(scratch, m, moved);
  for (std::size_t i = 1; i < m.edges; i += hn::Lanes(d)) {
    const V gaps =
        hn::Sub(hn::LoadU(d, scratch.edges.data() + i), hn::LoadU(d, scratch.edges.data() + i - 1));
    if (hn::AllFalse(d, hn::Gt(gaps, limit))) continue;
    const std::size_t end = std::min<std::size_t>(i + hn::Lanes(d), m.edges);
    for (std::size_t k = i; k < end; ++k) {
      if (scratch.edges[k] - scratch.edges[k - 1] > pause && pauses.may_be(k)) return true;
    }
  }
  return false;
}

using Words = std::array<std::uint64_t, CleanMeasure::bit_words>;

// Marks the places at which the level changes, from this word on.
inline void mark_changes(const CleanScratch& scratch, std::size_t changes, std::size_t first_word,
                         Words& toggles) {
  for (std::size_t i = 0; i < changes; ++i) {
    const auto at = static_cast<std::uint32_t>(scratch.samples[i]);
    const std::size_t word = at / 64;
    if (word < first_word || word >= toggles.size()) continue;
    toggles[word] ^= std::uint64_t{1} << (63U - at % 64U);
  }
}

// WebAssembly has no shift of 64 bits with a count for each lane.
#if HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_WASM
// The same in the first two words, which are enough for nearly all cycles.
HWY_INLINE void mark_first_changes(const CleanScratch& scratch, std::size_t changes,
                                   Words& toggles) {
  const hn::ScalableTag<std::uint64_t> d;
  const hn::Rebind<std::uint32_t, decltype(d)> narrow;
  const auto top = hn::Set(d, std::uint64_t{1} << 63U);
  const auto in_word = hn::Set(d, std::uint64_t{63});
  auto first = hn::Zero(d);
  auto second = hn::Zero(d);
  for (std::size_t i = 0; i < changes; i += hn::Lanes(d)) {
    const auto* samples = reinterpret_cast<const std::uint32_t*>(scratch.samples.data() + i);
    const auto at = hn::PromoteTo(d, hn::LoadU(narrow, samples));
    const auto bit = hn::Shr(top, hn::And(at, in_word));
    const auto word = hn::ShiftRight<6>(at);
    first = hn::Xor(first, hn::IfThenElseZero(hn::Eq(word, hn::Zero(d)), bit));
    second = hn::Xor(second, hn::IfThenElseZero(hn::Eq(word, hn::Set(d, std::uint64_t{1})), bit));
  }
  const hn::CappedTag<std::uint64_t, 2> two;
  hn::StoreU(fold_both(d, first, second, TakeDifference()), two, toggles.data());
}
#endif

// The bits from the places of the changes. SLO is high before the first sample; the samples of an ACK
// of two clocks, START, CDS 0 and the data 110:
//
//   sample     0   1   2   3   4   5   6   7
//             ___         ___     _______
//   SLO          |_______|   |___|       |___
//   changes        1       3   4   5       7   by the first sample after each
//   toggles    0   1   0   1   1   1   0   1
//   level      1   0   0   1   0   1   1   0   1, inverted by all toggles up to it
//
// The XOR of a word with itself, shifted by 1, 2, 4, …, 32, has at each bit the XOR of all bits up
// to it. Its last bit is the level with which the next word begins.
HWY_INLINE void collect_bits(const CleanScratch& scratch, CleanMeasure& m) {
  Words toggles{};
#if HWY_TARGET == HWY_SCALAR || HWY_TARGET == HWY_WASM
  mark_changes(scratch, m.changes, 0, toggles);
#else
  mark_first_changes(scratch, m.changes, toggles);
  if (m.rises > 128) mark_changes(scratch, m.changes, 2, toggles);
#endif
  std::uint64_t level = ~std::uint64_t{0};
  const std::size_t words = (m.rises + 63) / 64;
  for (std::size_t w = 0; w < words; ++w) {
    std::uint64_t word = toggles[w];
    for (unsigned shift = 1; shift < 64; shift *= 2) word ^= word >> shift;
    word ^= level;
    level = (word & 1U) != 0 ? ~std::uint64_t{0} : 0;
    // The first bit is the uppermost of the first byte.
    word = __builtin_bswap64(word);
    std::memcpy(m.bytes.data() + 8 * w, &word, sizeof word);
  }
}

// Finds the end of the cycle, and its clock.
HWY_INLINE bool split(const CleanLines& lines, CleanScratch& scratch, CleanMeasure& m,
                      Clock& clock) {
  const D d;
  Times& edges = scratch.edges;
  if (lines.ma.size() < least_edges + 2) return false;
  const std::int64_t begin = lines.ma[0];
  if (since(begin, lines.ma[2]) > longest_period) return false;
  // Well between the gaps of the clock and a pause; verified below, once the clock is known.
  const auto first_period = static_cast<std::int32_t>(lines.ma[2] - begin);
  const V gap_limit = hn::Set(d, first_period + first_period / 4);
  std::size_t end = 0;
  ClockSums sums;
  std::size_t count = convert(
      lines.ma, begin, edges, [&](std::size_t from, std::size_t to, V, V gaps, V steps) HWY_ATTR {
        const M longer = hn::And(hn::Gt(gaps, gap_limit), first_lanes(to - from));
        const auto found = hn::FindFirstTrue(d, longer);
        if (found < 0) {
          sums.add(gaps, steps);
          return false;
        }
        end = from + static_cast<std::size_t>(found);
        sums.add(gaps, steps, first_lanes(static_cast<std::size_t>(found)));
        return true;
      });
  // The rising edge to idle may be the last of a vector.
  if (end % 2 != 0 && end + 1 == count && count < lines.ma.size()) {
    edges[count] = after(lines.ma[count], begin);
    ++count;
  }
  if (end < least_edges || end + 1 >= count + (end % 2 == 0 ? 1 : 0)) return false;
  m.edges = static_cast<std::uint32_t>(end);
  m.rises = m.edges / 2;
  m.next_fall = m.edges + m.edges % 2;
  m.last_edge = edges[end - 1];
  m.second_rise = edges[3];
  if (m.last_edge > longest_cycle || m.rises > CleanMeasure::bit_words * 64 - 2) return false;
  clock = sums.get(edges, end);
  m.limit =
      std::min(edges[m.next_fall], m.last_edge + static_cast<std::int32_t>(slo_matters.count));
  return true;
}

// The changes of SLO before the next request.
HWY_INLINE bool take_changes(const CleanLines& lines, CleanScratch& scratch, CleanMeasure& m) {
  const D d;
  const std::int64_t next = lines.ma[m.next_fall];
  if (lines.slo.size() < 2 || lines.slo[1] >= next) return false;
  const std::int32_t next_time = scratch.edges[m.next_fall];
  const V end = hn::Set(d, next_time);
  std::size_t found = 2;
  const std::size_t count =
      convert(lines.slo, lines.ma[0], scratch.changes,
              [&](std::size_t from, std::size_t to, V now, V, V) HWY_ATTR {
                found += hn::CountTrue(d, hn::And(hn::Lt(now, end), first_lanes(to - from)));
                return found < to;
              });
  if (next_time == far) {
    const auto begin = lines.slo.begin();
    found = static_cast<std::size_t>(std::lower_bound(begin, lines.slo.end(), next) - begin);
  }
  if (found > count || (found == count && count == CleanScratch::max_edges)) return false;
  // The order of two edges with the same time would matter.
  if (found < lines.slo.size() && lines.slo[found] == next) return false;
  m.changes = static_cast<std::uint32_t>(found);
  hn::StoreU(hn::Zero(d), d, scratch.changes.data() + found);
  return true;
}

HWY_INLINE bool is_even(const CleanScratch& scratch, const Clock& clock, const CleanMeasure& m) {
  const std::int32_t least = std::min(clock.rise_least, clock.fall_least);
  const std::int32_t most = std::max(clock.rise_most, clock.fall_most);
  const auto far_apart = [](std::int32_t interval, std::int32_t usual) {
    return irregular(Picoseconds{interval}, Picoseconds{usual});
  };
  // The decoder's estimate of the period lies between `least` and `most`.
  const std::int64_t rest = scratch.edges[m.edges] - m.last_edge;
  return least > 0 && most <= longest_period && clock.longest_gap < least &&
         4 * std::int64_t{clock.longest_gap} <= 5 * std::int64_t{least} &&
         4 * rest > 5 * std::int64_t{most} && 2 * std::int64_t{least} > most &&
         scratch.edges[1] * pulse_share >= most && !far_apart(clock.rise_most, clock.rise_least) &&
         !far_apart(clock.fall_least, m.period) && !far_apart(clock.fall_most, m.period);
}

// ACK is the first low of SLO, and lasts.
HWY_INLINE bool find_ack(const CleanScratch& scratch, const Clock& clock, CleanMeasure& m) {
  m.fall = scratch.changes[0];
  const std::int32_t settled = std::max(m.fall + clock.rise_most / 2 + 1, m.second_rise);
  return m.fall < m.limit && scratch.changes[1] > settled;
}

bool measure(const CleanLines& lines, const CleanSetup& setup, CleanScratch& scratch,
             CleanMeasure& m) {
  Clock clock;
  if (!split(lines, scratch, m, clock)) return false;
  const Times& edges = scratch.edges;
  const std::int32_t last_rise = edges[2 * m.rises - 1];
  const auto periods = static_cast<std::int32_t>(m.rises) - 1;
  m.period = (last_rise - edges[1] + periods / 2) / periods;
  m.jitter = clock.rise_most - clock.rise_least;
  m.high = clock.high;
  m.highs = static_cast<std::int32_t>(m.edges - 1) / 2;
  if (!is_even(scratch, clock, m) || !take_changes(lines, scratch, m)) return false;
  if (setup.clock_change) m.clock_change = clock_change(edges, m.rises);
  if (!find_ack(scratch, clock, m)) return false;
  if (has_pause(scratch, m, clock)) return false;

  const std::int32_t half = m.period / 2;
  const float per_period = 1.0F / static_cast<float>(m.period);
  // Later changes must not count: they may be unknown when the cycle is read.
  if (last_rise + (m.fall - m.second_rise) + half >= m.limit) return false;
  const Measured rises(edges, static_cast<std::int32_t>(m.rises));
  if (!measure_delay(clock, rises, per_period, scratch, m)) return false;
  if (last_rise + m.delay + half >= m.limit) return false;
  const auto margin = static_cast<std::int32_t>(m.period / margin_share - setup.margin_doubt);
  if (!place_samples(rises, per_period, margin, scratch, m)) return false;
  // Only ACK may move SLO before its own sample.
  if (scratch.samples[0] != 1 || scratch.samples[1] < 2) return false;
  collect_bits(scratch, m);
  return true;
}

}  // namespace biss::decode::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace biss::decode {

HWY_EXPORT(measure);

bool measure_clean(const CleanLines& lines, const CleanSetup& setup, CleanScratch& scratch,
                   CleanMeasure& found) {
  return HWY_DYNAMIC_DISPATCH(measure)(lines, setup, scratch, found);
}

}  // namespace biss::decode
#endif
