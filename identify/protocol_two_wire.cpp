// Two lines that both matter at each change: I2C and the quadrature signals of an incremental encoder.
#include <fmt/format.h>

#include "identify/protocol_lines.hpp"

namespace biss::identify {

namespace {

struct Change {
  Picoseconds time{};
  bool of_second = false;
  /// The level from here on.
  bool high = false;
};

// The changes of both lines in the order of time.
std::vector<Change> merged(const Trace& first, const Trace& second) {
  std::vector<Change> all;
  for (const Trace* line : {&first, &second}) {
    for (std::size_t i = 0; i < line->changes.size(); ++i) {
      all.push_back({line->changes[i], line == &second, line->level_before(i + 1)});
    }
  }
  std::inplace_merge(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(first.changes.size()),
                     all.end(), [](const Change& a, const Change& b) { return a.time < b.time; });
  return all;
}

// Follows START, bytes of nine clocks, repeated START, STOP.
void try_i2c(const Trace& clock, const Trace& data, bool inverted, Guesses& guesses) {
  if (clock.changes.size() < 38) return;
  bool clock_high = true;
  bool started = false;
  std::size_t rises = 0;
  std::size_t starts = 0;
  std::size_t parts = 0;
  std::size_t good = 0;
  std::size_t bytes = 0;
  std::size_t shifts = 0;
  for (const Change& change : merged(clock, data)) {
    if (!change.of_second) {
      clock_high = change.high != inverted;
      rises += clock_high ? 1U : 0U;
      continue;
    }
    if (!clock_high) {
      ++shifts;
      continue;
    }
    parts += started ? 1U : 0U;
    // Before STOP and repeated START the clock rises once more.
    if (started && rises > 1 && rises % 9 == 1) {
      ++good;
      bytes += rises / 9;
    }
    started = change.high == inverted;
    starts += started ? 1U : 0U;
    rises = 0;
  }
  const double whole = share(good, parts);
  if (parts < 2 || bytes < 4 || shifts < 2 * parts || whole < 0.8) return;
  guesses.push_back({Protocol::i2c, (whole > 0.9 ? 0.95 : 0.8) * std::min(1.0, share(bytes, 8)),
                     fmt::format("{} starts, {} of {} parts have whole bytes of nine clocks",
                                 starts, good, parts)});
}

void try_quadrature(const Trace& a, const Trace& b, Guesses& guesses) {
  if (a.changes.size() < 16 || b.changes.size() < 16) return;
  const std::vector<Change> changes = merged(a, b);
  const std::size_t steps = changes.size() - 1;
  std::size_t alternating = 0;
  std::vector<double> places;
  for (std::size_t i = 1; i < changes.size(); ++i) {
    if (changes[i].of_second == changes[i - 1].of_second) continue;
    ++alternating;
    const double before = i == 1 ? 0 : length(changes[i - 2].time, changes[i - 1].time);
    const double gap = length(changes[i - 1].time, changes[i].time);
    if (before > 0) places.push_back(gap / (gap + before));
  }
  const double centred =
      share_of(places, [](double place) { return place > 0.15 && place < 0.85; });
  if (share(alternating, steps) < 0.93 || centred < 0.85) return;
  guesses.push_back(
      {Protocol::quadrature, 0.92 * std::min(1.0, share(steps, 48)),
       fmt::format("{} of {} changes alternate between the lines, a quarter period apart",
                   alternating, steps)});
}

}  // namespace

void try_two_wire(const Scene& scene, Guesses& guesses) {
  for (const Trace& first : scene.lines) {
    for (const Trace& second : scene.lines) {
      if (&first == &second) continue;
      try_i2c(first, second, false, guesses);
      // A free bus has a high clock, unless there is an inverter in between.
      if (!first.clock.idle_high) try_i2c(first, second, true, guesses);
      if (&first < &second) try_quadrature(first, second, guesses);
    }
  }
}

}  // namespace biss::identify
