#include "decode/clean_measure.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

// Of the levels between, the compilers' time is not worth the gain.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "decode/clean_measure.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h.
#include <hwy/highway.h>

#include "decode/cycle_rules.hpp"
#include "decode/intervals.hpp"

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

HWY_INLINE M first_lanes(std::size_t count) {
  const D d;
  return hn::FirstN(d, std::min(count, hn::Lanes(d)));
}

struct Least {
  V value;

  HWY_INLINE Least() : value(hn::Set(D(), none)) {}
  HWY_INLINE void add(V v, M valid) {
    value = hn::Min(value, hn::IfThenElse(valid, v, hn::Set(D(), none)));
  }
  HWY_INLINE std::int32_t get() const { return hn::GetLane(hn::MinOfLanes(D(), value)); }
};

struct Most {
  V value;

  HWY_INLINE Most() : value(hn::Set(D(), -none)) {}
  HWY_INLINE void add(V v, M valid) {
    value = hn::Max(value, hn::IfThenElse(valid, v, hn::Set(D(), -none)));
  }
  HWY_INLINE std::int32_t get() const { return hn::GetLane(hn::MaxOfLanes(D(), value)); }
};

// times[i] - begin for whole vectors from `from` on, up to the first that is `far` or more: those are
// `far`. `done` gets the place, the new times, and their distances from the times before, which
// hold where both are below `far`. \return the end of what was converted
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
  out[0] = static_cast<std::int32_t>(std::min<std::int64_t>(times[0] - begin, far));
  std::size_t i = 1;
  for (; i + lanes <= count && times[i + lanes - 1] - begin < far; i += lanes) {
    const V low = low_halves(i);
    hn::StoreU(hn::Sub(low, base), d, out.data() + i);
    if (done(i, i + lanes, hn::Sub(low, base), hn::Sub(low, low_halves(i - 1)))) return i + lanes;
  }
  // Those that are left, one by one: the end of the array, or the last ones before a long pause.
  const std::size_t end = std::min(i + lanes, count);
  for (std::size_t k = i; k < end; ++k) {
    out[k] = static_cast<std::int32_t>(std::min<std::int64_t>(times[k] - begin, far));
  }
  if (i < end) {
    const V now = hn::LoadU(d, out.data() + i);
    done(i, end, now, hn::Sub(now, hn::LoadU(d, out.data() + i - 1)));
  }
  return end;
}

// What MA shows.
struct Clock {
  std::int32_t longest_gap = 0;
  std::int32_t rise_least = 0;
  std::int32_t rise_most = 0;
  std::int32_t fall_least = 0;
  std::int32_t fall_most = 0;
  std::int32_t high = 0;
};

HWY_INLINE Clock measure_clock(const Times& edges, std::size_t count, Times& rises) {
  const D d;
  const std::size_t lanes = hn::Lanes(d);
  Most gaps;
  Least rise_least;
  Most rise_most;
  Least fall_least;
  Most fall_most;
  V high = hn::Zero(d);
  const std::size_t rise_count = count / 2;
  const std::size_t fall_count = count - rise_count;
  for (std::size_t i = 0; i < fall_count; i += lanes) {
    V fall;
    V rise;
    V next_fall;
    V next_rise;
    hn::LoadInterleaved2(d, edges.data() + 2 * i, fall, rise);
    hn::LoadInterleaved2(d, edges.data() + 2 * i + 2, next_fall, next_rise);
    hn::StoreU(rise, d, rises.data() + i);
    const M is_rise = first_lanes(rise_count - std::min(rise_count, i));
    const M has_fall = first_lanes(fall_count - 1 - std::min(fall_count - 1, i));
    const M has_rise = first_lanes(rise_count - 1 - std::min(rise_count - 1, i));
    const V high_now = hn::Sub(next_fall, rise);
    gaps.add(hn::Sub(rise, fall), is_rise);
    gaps.add(high_now, has_fall);
    high = hn::Add(high, hn::IfThenElseZero(has_fall, high_now));
    const V falls = hn::Sub(next_fall, fall);
    fall_least.add(falls, has_fall);
    fall_most.add(falls, has_fall);
    const V rise_step = hn::Sub(next_rise, rise);
    rise_least.add(rise_step, has_rise);
    rise_most.add(rise_step, has_rise);
  }
  rises[rise_count] = far;
  return {.longest_gap = gaps.get(),
          .rise_least = rise_least.get(),
          .rise_most = rise_most.get(),
          .fall_least = fall_least.get(),
          .fall_most = fall_most.get(),
          .high = hn::GetLane(hn::SumOfLanes(d, high))};
}

// The longest of the gaps by which the decoder tells a pause.
HWY_INLINE std::int32_t longest_of_first(const Times& edges) {
  const D d;
  Most longest;
  for (std::size_t i = 1; i < lookahead_edges; i += hn::Lanes(d)) {
    longest.add(hn::Sub(hn::LoadU(d, edges.data() + i), hn::LoadU(d, edges.data() + i - 1)),
                first_lanes(lookahead_edges - i));
  }
  return longest.get();
}

HWY_INLINE std::int32_t clock_change(const Times& rises, std::size_t count) {
  const D d;
  std::int32_t most = 0;
  for (std::size_t apart = 1; apart <= 8 && apart < count; apart *= 2) {
    Least shortest;
    Most longest;
    for (std::size_t i = 0; i + apart < count; i += hn::Lanes(d)) {
      const V time =
          hn::Sub(hn::LoadU(d, rises.data() + i + apart), hn::LoadU(d, rises.data() + i));
      const M valid = first_lanes(count - apart - i);
      shortest.add(time, valid);
      longest.add(time, valid);
    }
    most = std::max(most, longest.get() - shortest.get());
  }
  return most;
}

// Rising edges as they were measured, and those of an even clock, which need not be looked up.
struct Measured {
  const std::int32_t* rises;

  HWY_INLINE V at(V index) const { return hn::GatherIndex(D(), rises, index); }
};
struct Even {
  std::int32_t begin;
  std::int32_t period;

  HWY_INLINE V at(V index) const {
    const D d;
    return hn::Add(hn::Set(d, begin), hn::Mul(index, hn::Set(d, period)));
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
  // that. False where they are not found soon: the clock is not even enough.
  HWY_INLINE bool find(V change, V& index, V& edge, V& edge_before) const {
    const D d;
    const hn::Rebind<float, D> df;
    const V one = hn::Set(d, 1);
    const V end = hn::Set(d, count);
    const V moved = hn::Sub(change, hn::Set(d, shift));
    const V from_second = hn::Sub(moved, hn::Set(d, second));
    const auto place = hn::Ceil(hn::Mul(hn::ConvertTo(df, from_second), hn::Set(df, per_period)));
    index = hn::Min(hn::Max(hn::Add(hn::ConvertTo(d, place), one), one), end);
    for (int i = 0; i < 4; ++i) {
      edge = rises.at(index);
      edge_before = rises.at(hn::Sub(index, one));
      const M later = hn::And(hn::Lt(edge, moved), hn::Lt(index, end));
      const M earlier = hn::And(hn::Gt(hn::Add(edge_before, one), moved), hn::Gt(index, one));
      if (hn::AllFalse(d, hn::Or(later, earlier))) return true;
      index = hn::Add(index, hn::IfThenElseZero(later, one));
      index = hn::Sub(index, hn::IfThenElseZero(earlier, one));
    }
    return false;
  }

  // The same where what was found for another shift may hold.
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

// From an edge of the clock to SLO's change, averaged over the cycle. `keep` gets what was found for
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
  // The change that makes ACK is off by nothing, and counted.
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
  const std::int32_t total = hn::GetLane(hn::SumOfLanes(d, sum));
  delay.mean = first + total / static_cast<std::int32_t>(valid_count);
  delay.spread = hn::GetLane(hn::MaxOfLanes(d, most)) - hn::GetLane(hn::MinOfLanes(d, least));
  return true;
}

// The beginning of an even clock that fits best; false where the clock is not even.
HWY_INLINE bool lay_even_clock(const Times& rises, std::int32_t count, std::int32_t period,
                               std::int32_t& begin) {
  const D d;
  const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
  const V step = hn::Set(d, period);
  const V half = hn::Set(d, period / 2);
  V sum = hn::Zero(d);
  M uneven = hn::FirstN(d, 0);
  for (std::int32_t i = 0; i < count; i += lanes) {
    const auto at = static_cast<std::size_t>(i);
    const V place = hn::Add(hn::Set(d, rises[0]), hn::Mul(hn::Iota(d, i), step));
    const V off = hn::IfThenElseZero(first_lanes(static_cast<std::size_t>(count - i)),
                                     hn::Sub(hn::LoadU(d, rises.data() + at), place));
    // Of whole numbers, 2 * off > period where off > period / 2.
    uneven = hn::Or(uneven, hn::Gt(hn::Abs(off), half));
    sum = hn::Add(sum, off);
  }
  begin = rises[0] + hn::GetLane(hn::SumOfLanes(d, sum)) / count;
  return hn::AllFalse(d, uneven);
}

// `sampling_delay` of CycleReader. What was found of the clock as it was measured stays in `scratch`.
HWY_INLINE bool measure_delay(const Clock& clock, float per_period, CleanScratch& scratch,
                              CleanMeasure& m) {
  const D d;
  const auto keep = [&](std::size_t i, V index, V edge, V edge_before) HWY_ATTR {
    hn::StoreU(index, d, scratch.samples.data() + i);
    hn::StoreU(edge, d, scratch.found.data() + i);
    hn::StoreU(edge_before, d, scratch.found_before.data() + i);
  };
  const std::int32_t first = scratch.rises[0];
  const Times& changes = scratch.changes;
  Delay seen;
  const bool exact = clock.rise_least == clock.rise_most;
  const bool found =
      exact ? delay_from(Even{first, m.period}, m.second_rise, m, per_period, changes, seen, keep)
            : delay_from(Measured{scratch.rises.data()}, m.second_rise, m, per_period, changes,
                         seen, keep);
  if (!found) return false;
  m.delay = seen.mean;
  std::int32_t begin = 0;
  if (8 * seen.spread <= m.period ||
      !lay_even_clock(scratch.rises, static_cast<std::int32_t>(m.rises), m.period, begin)) {
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

// The sample that each change of SLO is the first to precede, and the first sample that is close.
HWY_INLINE bool place_samples(float per_period, std::int32_t margin, CleanScratch& scratch,
                              CleanMeasure& m) {
  const D d;
  const auto rise_count = static_cast<std::int32_t>(m.rises);
  const std::int32_t shift = m.delay + m.period / 2;
  const Grid<Measured> grid{{scratch.rises.data()}, rise_count, m.second_rise, shift, per_period};
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

// A gap that is a little longer than those at the beginning: may the encoder have gone idle in it?
// The last change of SLO in it would be a rise, and SLO high at the next falling edge.
inline bool may_be_pause(const CleanScratch& scratch, const CleanMeasure& m, const Clock& clock,
                         std::size_t edge) {
  const Times& changes = scratch.changes;
  const std::int32_t last = scratch.edges[edge - 1];
  const std::int32_t here = scratch.edges[edge];
  const auto end = changes.begin() + m.changes;
  const auto after = std::upper_bound(changes.begin(), end, here);
  if (after == changes.begin() || *(after - 1) <= last) return false;
  const bool rose = (after - changes.begin()) % 2 == 0;
  if (!rose) return false;
  const std::int32_t next = edge % 2 == 0 ? here : scratch.edges[edge + 1];
  const bool high = (std::upper_bound(after, end, next) - changes.begin()) % 2 == 0;
  if (!high) return false;
  const std::int32_t rise = *(after - 1);
  const std::int32_t line_delay = std::max(0, m.fall - m.second_rise);
  return rise > last + line_delay + clock.rise_least / 4 && rise < here;
}

inline bool has_pause(const CleanScratch& scratch, const CleanMeasure& m, const Clock& clock,
                      std::int32_t pause) {
  for (std::size_t i = 1; i < m.edges; ++i) {
    if (scratch.edges[i] - scratch.edges[i - 1] > pause && may_be_pause(scratch, m, clock, i)) {
      return true;
    }
  }
  return false;
}

HWY_INLINE void collect_bits(const CleanScratch& scratch, CleanMeasure& m) {
  // Nearly all cycles have no more than two words: these stay in registers.
  std::array<std::uint64_t, CleanMeasure::bit_words + 1> toggles{};
  std::uint64_t first = 0;
  std::uint64_t second = 0;
  for (std::size_t i = 0; i < m.changes; ++i) {
    const auto at = static_cast<std::uint32_t>(scratch.samples[i]);
    const std::uint64_t bit = std::uint64_t{1} << (63U - at % 64U);
    first ^= at < 64 ? bit : 0;
    second ^= at / 64 == 1 ? bit : 0;
    if (at >= 128) toggles[std::min<std::size_t>(at / 64, CleanMeasure::bit_words)] ^= bit;
  }
  toggles[0] = first;
  toggles[1] = second;
  std::uint64_t level = ~std::uint64_t{0};
  const std::size_t words = (m.rises + 63) / 64;
  for (std::size_t w = 0; w < words; ++w) {
    std::uint64_t word = toggles[w];
    for (unsigned shift = 1; shift < 64; shift *= 2) word ^= word >> shift;
    m.bits[w] = word ^ level;
    level = (m.bits[w] & 1U) != 0 ? ~std::uint64_t{0} : 0;
  }
}

// Finds the end of the cycle.
HWY_INLINE bool split(const CleanLines& lines, CleanScratch& scratch, CleanMeasure& m) {
  const D d;
  Times& edges = scratch.edges;
  if (lines.ma.size() < least_edges + 2) return false;
  const std::int64_t begin = lines.ma[0];
  if (lines.ma[2] - begin > longest_period) return false;
  // Well between the gaps of the clock and a pause; verified below, once the clock is known.
  const auto first_period = static_cast<std::int32_t>(lines.ma[2] - begin);
  const V gap_limit = hn::Set(d, first_period + first_period / 4);
  std::size_t end = 0;
  const std::size_t count =
      convert(lines.ma, begin, edges, [&](std::size_t from, std::size_t to, V, V gaps) HWY_ATTR {
        const M longer = hn::And(hn::Gt(gaps, gap_limit), first_lanes(to - from));
        const auto found = hn::FindFirstTrue(d, longer);
        if (found < 0) return false;
        end = from + static_cast<std::size_t>(found);
        return true;
      });
  if (end < least_edges || end + 1 >= count + (end % 2 == 0 ? 1 : 0)) return false;
  m.edges = static_cast<std::uint32_t>(end);
  m.rises = m.edges / 2;
  m.next_fall = m.edges + m.edges % 2;
  m.last_edge = edges[end - 1];
  m.second_rise = edges[3];
  if (m.last_edge > longest_cycle || m.rises > CleanMeasure::bit_words * 64 - 2) return false;
  m.limit =
      std::min(edges[m.next_fall], m.last_edge + static_cast<std::int32_t>(slo_matters.count));
  return true;
}

// The changes of SLO before the next request.
HWY_INLINE bool take_changes(const CleanLines& lines, CleanScratch& scratch, CleanMeasure& m) {
  const D d;
  const std::int64_t next = lines.ma[m.next_fall];
  if (lines.slo.empty() || lines.slo[0] >= next) return false;
  const std::int32_t next_time = scratch.edges[m.next_fall];
  const V end = hn::Set(d, next_time);
  std::size_t found = 1;
  const std::size_t count =
      convert(lines.slo, lines.ma[0], scratch.changes,
              [&](std::size_t from, std::size_t to, V now, V) HWY_ATTR {
                found += hn::CountTrue(d, hn::And(hn::Lt(now, end), first_lanes(to - from)));
                return found < to;
              });
  if (next_time == far) {
    const auto begin = lines.slo.begin();
    found = static_cast<std::size_t>(std::lower_bound(begin, lines.slo.end(), next) - begin);
  }
  if (found > count || (found == count && count == CleanScratch::max_edges)) return false;
  // Which of two edges at one time comes first would matter.
  if (found < lines.slo.size() && lines.slo[found] == next) return false;
  m.changes = static_cast<std::uint32_t>(found);
  hn::StoreU(hn::Zero(d), d, scratch.changes.data() + found);
  return m.changes >= 2;
}

HWY_INLINE bool is_even(const CleanScratch& scratch, const Clock& clock, const CleanMeasure& m) {
  const std::int32_t least = std::min(clock.rise_least, clock.fall_least);
  const std::int32_t most = std::max(clock.rise_most, clock.fall_most);
  const auto far_apart = [](std::int32_t interval, std::int32_t usual) {
    return irregular({interval}, {usual});
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
  if (!split(lines, scratch, m)) return false;
  const Clock clock = measure_clock(scratch.edges, m.edges, scratch.rises);
  const Times& rises = scratch.rises;
  const auto rise_count = static_cast<std::int32_t>(m.rises);
  const std::int32_t periods = rise_count - 1;
  m.period = (rises[m.rises - 1] - rises[0] + periods / 2) / periods;
  m.jitter = clock.rise_most - clock.rise_least;
  m.high = clock.high;
  m.highs = static_cast<std::int32_t>(m.edges - 1) / 2;
  if (!is_even(scratch, clock, m) || !take_changes(lines, scratch, m)) return false;
  if (setup.clock_change) m.clock_change = clock_change(rises, m.rises);
  if (!find_ack(scratch, clock, m)) return false;
  // The decoder's pause is at least this long.
  const std::int32_t pause =
      longest_of_first(scratch.edges) +
      std::min(clock.rise_least, clock.fall_least) / static_cast<std::int32_t>(pause_share);
  if (clock.longest_gap > pause && has_pause(scratch, m, clock, pause)) return false;

  const std::int32_t half = m.period / 2;
  const float per_period = 1.0F / static_cast<float>(m.period);
  // Nothing that comes later may count: it may not have been seen when the cycle is read.
  if (rises[m.rises - 1] + (m.fall - m.second_rise) + half >= m.limit) return false;
  if (!measure_delay(clock, per_period, scratch, m)) return false;
  if (rises[m.rises - 1] + m.delay + half >= m.limit) return false;
  const auto margin = static_cast<std::int32_t>(m.period / margin_share - setup.margin_doubt);
  if (!place_samples(per_period, margin, scratch, m)) return false;
  // ACK alone moves SLO before its own sample.
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
