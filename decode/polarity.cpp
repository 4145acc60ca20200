#include "decode/polarity.hpp"

#include <algorithm>
#include <utility>

#include "decode/times.hpp"

namespace biss::decode {

namespace {

constexpr std::size_t edges_to_try = 40'000;

// How well the cycles read in one polarity.
struct Reading {
  Lines lines;
  std::size_t cycles = 0;
  std::size_t good = 0;
  // Cycles in which START was found, with any result after it.
  std::size_t answered = 0;
  Picoseconds longest_period{};

  bool is_mostly_good() const { return 2 * good > cycles; }
  bool is_better_than(const Reading& other) const {
    return good != other.good ? good > other.good : answered > other.answered;
  }
};

Reading read(const Lines& lines, std::span<const wire::Edge> edges, const CycleReader& reader) {
  Reading reading{.lines = lines};
  Decoder decoder(reader, [&](const Cycle& cycle) {
    ++reading.cycles;
    if (is_good(cycle.status)) ++reading.good;
    if (cycle.ack) ++reading.answered;
    if (cycle.period) reading.longest_period = std::max(reading.longest_period, *cycle.period);
  });
  decoder.push(edges, lines);
  decoder.finish(edges.empty() ? Picoseconds{} : edges.back().time);
  return reading;
}

// Whether MA, as the capture shows it, is low in most of the longest gaps before requests. In a shorter
// one, a master may pause within a request.
bool rests_low(wire::LineIndex ma, std::span<const wire::Edge> edges, Picoseconds period) {
  using Rest = std::pair<Picoseconds, bool>;
  std::vector<Rest> rests;
  std::optional<wire::Edge> last;
  std::optional<Rest> rest;
  for (const wire::Edge& edge : edges) {
    if (edge.line != ma) continue;
    if (last && 4 * elapsed(last->time, edge.time) > 5 * period) {
      rest = {elapsed(last->time, edge.time), last->level == wire::Level::low};
    } else if (rest) {
      rests.push_back(*std::exchange(rest, std::nullopt));
    }
    last = edge;
  }
  if (rests.empty()) return false;
  const Picoseconds longest = std::max_element(rests.begin(), rests.end())->first;
  std::int64_t low = 0;
  for (const auto& [length, is_low] : rests) {
    if (5 * length >= 4 * longest) low += is_low ? 1 : -1;
  }
  return low > 0;
}

// Whether MA comes in bytes or words, and SLO is high at the end of most long gaps, as it rests
// between requests unless it is inverted.
bool slo_rests_high(const Lines& lines, std::span<const wire::Edge> edges, Picoseconds period) {
  // The gaps, and whether SLO is high at their ends; how many edges of MA are between two gaps.
  std::vector<std::pair<Picoseconds, bool>> gaps;
  std::vector<std::size_t> bursts;
  std::size_t burst = 0;
  std::optional<Picoseconds> last;
  bool high = true;
  for (const wire::Edge& edge : edges) {
    if (edge.line != lines.ma) {
      high = edge.level != wire::Level::low;
      continue;
    }
    if (last && 4 * elapsed(*last, edge.time) > 5 * period) {
      gaps.emplace_back(elapsed(*last, edge.time), high);
      bursts.push_back(std::exchange(burst, 0));
    }
    ++burst;
    last = edge.time;
  }
  if (gaps.empty()) return false;
  constexpr std::size_t word_edges = 32;
  std::nth_element(bursts.begin(), bursts.begin() + std::ssize(bursts) / 2, bursts.end());
  if (bursts[bursts.size() / 2] > word_edges) return false;
  const Picoseconds longest = std::max_element(gaps.begin(), gaps.end())->first;
  std::size_t highs = 0;
  std::size_t lows = 0;
  for (const auto& [gap, is_high] : gaps) {
    if (2 * gap >= longest) ++(is_high ? highs : lows);
  }
  return highs > 3 * lows;
}

}  // namespace

std::vector<wire::Edge> first_edges(const Lines& lines, std::span<const wire::Edge> edges) {
  std::vector<wire::Edge> pair;
  for (const wire::Edge& edge : edges) {
    if (edge.line != lines.ma && edge.line != lines.slo) continue;
    pair.push_back(edge);
    if (pair.size() == edges_to_try) break;
  }
  return pair;
}

Lines find_polarity(const Lines& lines, std::span<const wire::Edge> beginning,
                    const CycleReader& reader) {
  const std::vector<wire::Edge> edges = first_edges(lines, beginning);
  const Reading as_is = read(lines, edges, reader);
  const bool low = !lines.ma_inverted && as_is.longest_period.count != 0 &&
                   rests_low(lines.ma, edges, as_is.longest_period);
  Reading best = as_is;
  const auto try_other = [&](bool ma_inverted, bool slo_inverted) {
    const Reading other = read({lines.ma, lines.slo, ma_inverted, slo_inverted}, edges, reader);
    const bool as_good = ma_inverted && !best.lines.ma_inverted && other.answered != 0 &&
                         !best.is_better_than(other);
    if (as_good || other.is_better_than(best)) best = other;
  };
  if (low) try_other(true, lines.slo_inverted);
  if (best.is_mostly_good() || lines.slo_inverted) return best.lines;
  // The parts of requests with pauses read at least as well inverted.
  const bool joins = !reader.checked_payload_bits() && !reader.knows_timeout();
  if (joins && find_paused_timeout(best.lines, edges)) return best.lines;
  if (slo_rests_high(lines, edges, as_is.longest_period)) return best.lines;
  if (low) try_other(true, true);
  if (!best.is_mostly_good()) try_other(lines.ma_inverted, true);
  return best.lines;
}

std::optional<Timeout> find_paused_timeout(const Lines& lines,
                                           std::span<const wire::Edge> beginning) {
  const std::vector<wire::Edge> edges = first_edges(lines, beginning);
  const Reading as_is = read(lines, edges, CycleReader(std::nullopt, {}));
  if (5 * as_is.good >= 4 * as_is.cycles || as_is.longest_period.count == 0) return std::nullopt;
  const wire::Level low = lines.slo_inverted ? wire::Level::high : wire::Level::low;
  // From the last edge of MA to the rise of SLO in a gap of MA.
  std::vector<Picoseconds> releases;
  Picoseconds last_ma = edges.front().time;
  Picoseconds rise = last_ma;
  for (const wire::Edge& edge : edges) {
    if (edge.line != lines.ma) {
      rise = edge.level == low ? last_ma : edge.time;
      continue;
    }
    const bool is_gap = 10 * elapsed(last_ma, edge.time) > 11 * as_is.longest_period;
    if (is_gap && rise > last_ma) releases.push_back(elapsed(last_ma, rise));
    last_ma = rise = edge.time;
  }
  if (releases.empty()) return std::nullopt;
  // Most rises may come with the last clock before a pause.
  const auto most = releases.begin() + static_cast<std::ptrdiff_t>(releases.size() * 19 / 20);
  std::nth_element(releases.begin(), most, releases.end());
  DeviceTiming timing;
  timing.timeout.time = *most;
  const Reading joined = read(lines, edges, CycleReader(std::nullopt, timing));
  const bool explains =
      10 * joined.good >= 9 * joined.cycles && 3 * joined.cycles <= 2 * as_is.cycles;
  return explains ? std::optional(timing.timeout) : std::nullopt;
}

}  // namespace biss::decode
