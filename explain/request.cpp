#include "explain/request.hpp"

#include <algorithm>

#include "decode/distribution.hpp"
#include "decode/times.hpp"

namespace biss::explain {

namespace {

using decode::Cycle;
using decode::CycleEdges;
using decode::LevelChange;
using wire::Level;

// Parts of requests: MA pauses between them for longer than the decoder waits. Most pauses are
// equal and short. The part after a longer pause begins with ACK at the same line delay; hardly any
// other part has ACK and START there.
std::optional<Picoseconds> find_groups(std::span<const Cycle> cycles, Picoseconds period) {
  std::vector<Picoseconds> rests;
  decode::Distribution seen;
  for (std::size_t i = 1; i < cycles.size(); ++i) {
    const Picoseconds end = decode::shifted(cycles[i - 1].time, cycles[i - 1].clocked);
    rests.push_back(decode::elapsed(end, cycles[i].time));
    seen.add(rests.back().count);
  }
  constexpr std::size_t least_groups = 8;
  if (rests.size() < 2 * least_groups) return std::nullopt;
  const Picoseconds usual_rest{seen.median()};
  const auto is_first = [&](std::size_t i) { return 2 * rests[i] > 3 * usual_rest; };
  decode::Distribution delays;
  for (std::size_t i = 0; i < rests.size(); ++i) {
    const auto delay = cycles[i + 1].line_delay;
    if (is_first(i) && delay) delays.add(delay->count);
  }
  if (delays.count() == 0) return std::nullopt;
  const Picoseconds usual_delay{delays.median()};
  // Masters pause after bytes or words. Two clocks are a reduced frame.
  constexpr std::uint32_t word_clocks = 16;
  const auto is_word = [](const Cycle& cycle) {
    return cycle.rising_edges > 2 && cycle.rising_edges <= word_clocks;
  };
  if (3 * std::count_if(cycles.begin(), cycles.end(), is_word) < std::ssize(cycles)) {
    return std::nullopt;
  }
  // Requests that are first in a group, and all others: their number, and how many are answered.
  std::array<std::size_t, 2> all{};
  std::array<std::size_t, 2> answered{};
  for (std::size_t i = 0; i < rests.size(); ++i) {
    const std::size_t k = is_first(i) ? 0 : 1;
    ++all[k];
    const Cycle& cycle = cycles[i + 1];
    if (!cycle.line_delay || cycle.early || (k == 1 && !cycle.ack)) continue;
    const Picoseconds off = *cycle.line_delay - usual_delay;
    if (3 * std::max(off, -off) <= period) ++answered[k];
  }
  const bool found = all[0] >= least_groups && 3 * all[0] < 2 * all[1] &&
                     10 * answered[0] >= 8 * all[0] && 10 * answered[1] <= 4 * all[1];
  return found ? std::optional(usual_rest) : std::nullopt;
}

}  // namespace

std::string_view text_of(RequestKind kind) {
  constexpr std::array<std::string_view, kind_count> words{
      "good",
      "a good frame reports an error (nE = 0)",
      "the sign of life of a good frame is not one more than before",
      "a good frame has a position that no axis can have",
      "a frame for control communication alone",
      "the frame has a different number of bits",
      "MA pauses within a good frame",
      "the checksum is wrong",
      "the format does not fit",
      "bits are shifted by a clock",
      "SLO stays high",
      "SLO is low from the request to the next one",
      "SLO is low at the request and rises later",
      "SLO is low at a request that comes too soon",
      "SLO rests low and goes high with ACK, as an inverted SLO does",
      "SLO changes half a period early, with the falling edges of MA",
      "STOP is 1 after right checksums, and repeats the bit before",
      "MA stops in ACK",
      "START comes too late for the clocks of the master",
      "MA stops before the last bit of the frame",
      "MA stops before the last bit of the frame, and continues soon after",
      "MA stops within a request and stays low, or the request before or after it is missing",
      "SLO stays high from a bit on to STOP",
      "SLO stays low from a bit on to STOP",
      "a pulse on SLO",
      "a pulse on MA",
      "SLO changes far from its place in a bit",
      "the line delay changes",
      "SLO comes one or more clocks later than usual",
      "STOP is 1 after right checksums",
      "CDS is 1, but the format requires 0",
      "START is outside the encoder's bounds",
      "the checksum is right by another rule",
      "each clock is a bit of a number",
      "the edges follow no rule"};
  return words[static_cast<std::size_t>(kind)];
}

Usual usual_of(std::span<const Cycle> cycles, const std::optional<FrameFormat>& format) {
  Usual usual;
  decode::Distribution periods;
  decode::Distribution duties;
  decode::Distribution clocks;
  std::array<decode::Distribution, 3> delays;
  std::vector<std::int64_t> ends;
  std::vector<WrongFrame> wrong;
  decode::RawBits before;
  std::size_t good = 0;
  for (const Cycle& cycle : cycles) {
    if (cycle.period) periods.add(cycle.period->count);
    if (cycle.duty_per_mille) duties.add(*cycle.duty_per_mille);
    const BitView raw = cycle.raw.view();
    if (cycle.line_delay) {
      delays[is_good(cycle.status) ? 0 : raw.size_bits() != 0 ? 1 : 2].add(cycle.line_delay->count);
    }
    if (raw.size_bits() < 3) continue;
    clocks.add(cycle.rising_edges);
    std::size_t last = raw.size_bits();
    while (last > 1 && !raw[last - 1]) --last;
    ends.push_back(static_cast<std::int64_t>(last));
    constexpr std::size_t frames_kept = 1000;
    if (is_good(cycle.status)) ++good;
    if (!is_good(cycle.status) || !format) {
      if (wrong.size() < frames_kept) wrong.push_back({cycle.raw, before});
    }
    before = cycle.raw;
  }
  if (periods.count() != 0) usual.period = picoseconds(periods.median());
  usual.high = usual.period * (duties.count() == 0 ? 500 : duties.median()) / 1000;
  if (clocks.count() != 0) usual.clocks = static_cast<std::uint32_t>(clocks.median());
  for (const auto& each : delays) {
    if (each.count() == 0) continue;
    usual.delay = picoseconds(each.median());
    break;
  }
  usual.rest_in_group = find_groups(cycles, usual.period);
  if (format) {
    usual.payload_bits = format->payload_bits();
  } else if (!ends.empty()) {
    // The last 1 of a frame is directly before STOP, or earlier: the last place that more than a
    // few damaged frames have.
    std::sort(ends.begin(), ends.end());
    auto high = ends.size() > 1 ? ends.end() - 2 : ends.begin();
    const auto least = std::max<std::ptrdiff_t>(2, std::ssize(ends) / 12);
    for (auto end = ends.end(); end != ends.begin();) {
      const auto begin = std::lower_bound(ends.begin(), end, *(end - 1));
      if (end - begin >= least) {
        high = begin;
        break;
      }
      end = begin;
    }
    usual.payload_bits = static_cast<unsigned>(std::max<std::int64_t>(*high - 2, 1));
  }
  usual.checksum = find_variant(wrong, format, usual.payload_bits);
  usual.no_checksum_fits =
      format && !usual.checksum && wrong.size() >= 8 && good * 6 < wrong.size();
  return usual;
}

}  // namespace biss::explain
