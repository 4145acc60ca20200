#include "identify/protocol_pair.hpp"

#include <cmath>
#include <numbers>

namespace biss::identify {

namespace {

constexpr std::size_t bursts_used = 400;
// Of a period, pulses of data below this are no bits.
constexpr double glitch_share = 0.35;

// How far the changes of data keep to one phase after the edges of one direction.
struct Phase {
  double coherence = 0;
  // In periods after the edge: -0.5 to 0.5.
  double mean = 0;
  double count = 0;
};

// \param from 0: after the edges that leave the idle level, 1: after those that return to it
Phase phase_after(const Pair& pair, std::size_t from) {
  double cosine = 0;
  double sine = 0;
  Phase phase;
  for (const Burst& burst : pair.shape->bursts) {
    const Picoseconds begin = pair.clock->changes[burst.first];
    const Picoseconds stop = later(pair.clock->changes[burst.last], 0.9 * pair.period());
    std::size_t edge = burst.first + from;
    for (std::size_t i = pair.data.after(begin); i < pair.data.changes.size(); ++i) {
      const Picoseconds time = pair.data.changes[i];
      if (time > stop) break;
      while (edge + 2 <= burst.last && pair.clock->changes[edge + 2] <= time) edge += 2;
      const Picoseconds last = pair.clock->changes[edge];
      const double off = last <= time ? length(last, time) : -length(time, last);
      const double angle = 2 * std::numbers::pi * off / pair.period();
      cosine += std::cos(angle);
      sine += std::sin(angle);
      ++phase.count;
    }
  }
  if (phase.count == 0) return phase;
  phase.coherence = std::hypot(cosine, sine) / phase.count;
  phase.mean = std::atan2(sine, cosine) / (2 * std::numbers::pi);
  return phase;
}

// Where the clock pauses within a word, only the edges that move the data show the phase.
void measure_phase(Pair& pair) {
  const Phase leaving = phase_after(pair, 0);
  const Phase returning = phase_after(pair, 1);
  const bool other = leaving.coherence > returning.coherence + 0.05;
  pair.coherence = std::max(leaving.coherence, returning.coherence);
  pair.phase = other ? leaving.mean - 0.5 : returning.mean;
  if (pair.phase < -0.5) pair.phase += 1;
  pair.changes =
      returning.count / static_cast<double>(std::max<std::size_t>(pair.shape->bursts.size(), 1));
}

Transfer read_transfer(const Pair& pair, std::size_t index, Picoseconds end) {
  const std::vector<Burst>& bursts = pair.shape->bursts;
  const Burst& burst = bursts[index];
  const double period = pair.period();
  Transfer transfer;
  transfer.begin = pair.clock->changes[burst.first];
  transfer.end = pair.clock->changes[burst.last];
  transfer.pulses = burst.pulses();
  const Picoseconds just_before = later(transfer.begin, -0.1 * period);
  transfer.before = pair.data.level_at(just_before);
  const std::size_t first = pair.data.after(just_before);
  if (first > 0) {
    const double ago =
        length(pair.data.changes[first - 1], std::max(just_before, pair.data.changes[first - 1]));
    const bool own =
        index == 0 || pair.data.changes[first - 1] >
                          later(pair.clock->changes[bursts[index - 1].last], 2 * period);
    transfer.prepared = own && ago < 3 * period;
  }
  const std::size_t inside = pair.data.after(transfer.begin);
  if (inside < pair.data.changes.size() &&
      pair.data.changes[inside] < later(transfer.end, period)) {
    const Picoseconds edge = return_of(pair, burst, 0);
    const Picoseconds time = pair.data.changes[inside];
    transfer.first_change = (edge <= time ? length(edge, time) : -length(time, edge)) / period;
  }
  const double delay = (pair.phase < -0.25 ? pair.phase + 1 : std::max(pair.phase, 0.0)) * period;
  const Picoseconds settled = later(transfer.end, delay + 0.3 * period);
  const Picoseconds next = index + 1 < bursts.size()
                               ? later(pair.clock->changes[bursts[index + 1].first], -0.1 * period)
                               : end;
  transfer.after = pair.data.level_at(std::min(settled, next));
  for (std::size_t i = pair.data.after(settled); i < pair.data.changes.size(); ++i) {
    const Picoseconds time = pair.data.changes[i];
    if (time >= next) break;
    if (!transfer.release && time > transfer.end) transfer.release = length(transfer.end, time);
    ++transfer.gap_changes;
  }
  for (std::size_t k = 0; k < std::min(transfer.pulses, pulses_used); ++k) {
    transfer.bits.push_back(
        pair.data.level_at(later(return_of(pair, burst, k), (pair.phase + 0.5) * period)));
  }
  return transfer;
}

}  // namespace

Pair read_pair(const Scene& scene, std::size_t clock, std::size_t data) {
  Pair pair;
  pair.clock = &scene.traces[clock];
  pair.shape = &scene.clocks[clock];
  pair.line = &scene.traces[data];
  pair.data = without_pulses(*pair.line, glitch_share * pair.period());
  measure_phase(pair);
  const std::size_t count = std::min(pair.shape->bursts.size(), bursts_used);
  for (std::size_t i = 0; i < count; ++i) {
    pair.transfers.push_back(read_transfer(pair, i, scene.end));
  }
  return pair;
}

}  // namespace biss::identify
