// Lines without a clock: UART, encoders that use UART words, HIPERFACE DSL, noise.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <set>

#include "identify/protocol_lines.hpp"

namespace biss::identify {

namespace {

constexpr std::size_t intervals_used = 4'000;

// The line as bits of one length.
struct Grid {
  double bit = 0;
  // Mean distance of the intervals of up to ten bits from whole bits, in bits.
  double off = 1;
};

Grid grid_of(const std::vector<double>& intervals) {
  if (intervals.size() < 8) return {};
  const double shortest = nth_of(intervals, intervals.size() / 50 + 1);
  double bit = mean_within(intervals, 0.7 * shortest, 1.5 * shortest);
  for (int pass = 0; pass < 3 && bit > 0; ++pass) {
    double time = 0;
    double bits = 0;
    for (const double value : intervals) {
      const double whole = std::round(value / bit);
      if (whole < 1 || whole > 9) continue;
      time += value;
      bits += whole;
    }
    bit = bits == 0 ? 0 : time / bits;
  }
  // There is no grid if all edges have the same time.
  if (!(bit > 0)) return {};
  double off = 0;
  double measured = 0;
  for (const double value : intervals) {
    const double bits = value / bit;
    if (bits > 9.5) continue;
    off += std::abs(bits - std::round(bits));
    ++measured;
  }
  return {bit, measured == 0 ? 1 : off / measured};
}

// Words of a start bit, data and a stop bit.
struct Words {
  unsigned length_bits = 0;
  // The data of all words, and with a gap before the first one of each group.
  std::vector<unsigned> values;
  std::vector<std::vector<unsigned>> groups;
  // Without a stop bit.
  std::size_t wrong = 0;

  double error_share() const { return values.empty() ? 1 : share(wrong, values.size()); }
};

bool idles_high(const Trace& line, double bit) {
  double high = 0;
  for (std::size_t i = 0; i + 1 < line.changes.size(); ++i) {
    const double bits = line.interval(i) / bit;
    if (bits > 10.5) high += line.level_before(i + 1) ? bits : -bits;
  }
  return high >= 0;
}

Words read_words(const Trace& line, double bit, unsigned length_bits, Picoseconds end) {
  constexpr std::size_t words_used = 400;
  Words words{.length_bits = length_bits, .values = {}, .groups = {}};
  const bool idle = idles_high(line, bit);
  std::size_t at = 0;
  // Begins after a gap, if there is one: before it the place in a word is not known.
  for (std::size_t i = 1; i < std::min<std::size_t>(line.changes.size(), 200) && at == 0; ++i) {
    if (line.interval(i - 1) > length_bits * bit && line.level_before(i) == idle) at = i;
  }
  Picoseconds last_stop{};
  while (at < line.changes.size() && words.values.size() < words_used) {
    if (line.level_before(at) != idle) {
      ++at;
      continue;
    }
    const Picoseconds start = line.changes[at];
    const Picoseconds stop = later(start, (length_bits - 0.5) * bit);
    if (stop > end) break;
    unsigned value = 0;
    for (unsigned k = 1; k + 1 < length_bits; ++k) {
      if (line.level_at(later(start, (k + 0.5) * bit)) == idle) value |= 1U << (k - 1U);
    }
    if (line.level_at(stop) != idle) ++words.wrong;
    if (words.groups.empty() || length(last_stop, start) > 3 * bit) words.groups.emplace_back();
    words.groups.back().push_back(value);
    words.values.push_back(value);
    last_stop = stop;
    at = line.after(stop);
  }
  return words;
}

bool is_encoder_rate(double bit) {
  constexpr std::array<double, 5> bits{400e3, 250e3, 200e3, 125e3, 62.5e3};
  return std::any_of(bits.begin(), bits.end(),
                     [&](double each) { return std::abs(bit - each) < 0.03 * each; });
}

// The shortest words that fit best.
Words best_words(const Trace& line, double bit, Picoseconds end) {
  if (is_encoder_rate(bit)) {
    Words words = read_words(line, bit, 18, end);
    if (words.values.size() >= 20 && words.wrong == 0) return words;
  }
  Words best;
  for (const unsigned length_bits : {10U, 11U, 9U, 12U, 8U, 7U}) {
    Words words = read_words(line, bit, length_bits, end);
    if (best.values.empty() || words.error_share() < best.error_share() - 0.004)
      best = std::move(words);
  }
  return best;
}

// The answer of a Tamagawa or Panasonic encoder ends with the sum of all its bytes without carry.
bool ends_with_sum(const Words& words) {
  std::size_t answers = 0;
  std::size_t good = 0;
  for (const auto& group : words.groups) {
    if (group.size() < 4) continue;
    unsigned sum = 0;
    unsigned ones = 0;
    for (const unsigned value : group) {
      sum ^= value;
      ones |= value;
    }
    // The request may come right before its answer.
    if (ones != 0 && (sum == 0 || sum == group.front())) ++good;
    ++answers;
  }
  return words.length_bits == 10 && answers >= 3 && share(good, answers) > 0.8;
}

void try_dsl(const Trace& line, const std::vector<double>& intervals, const Grid& grid,
             Guesses& guesses) {
  constexpr double dsl_bit = 1e6 / 9.375;  // ps
  const double long_share = share_of(intervals, [&](double v) { return v / grid.bit > 5.5; });
  const bool rate = std::abs(grid.bit - dsl_bit) < 0.02 * dsl_bit;
  if (!rate || line.changes.size() < 300 || long_share > 0.005 || grid.off > 0.25) return;
  const double longest = *std::max_element(intervals.begin(), intervals.end());
  guesses.push_back({Protocol::hiperface_dsl, 0.95,
                     fmt::format("{:.3f} Mbit/s, {} changes, never more than {:.0f} equal bits",
                                 1e6 / grid.bit, line.changes.size(), longest / grid.bit)});
}

// \param trust the factor of the guess
void try_words(const Trace& line, const Grid& grid, const Scene& scene, double trust,
               Guesses& guesses) {
  const double coarse = 0.1 + 0.5 * scene.sample / std::max(grid.bit, 1.0);
  if (grid.bit <= 0 || grid.bit < 2.5 * scene.sample || grid.off > coarse) return;
  const Words words = best_words(line, grid.bit, scene.end);
  const std::size_t count = words.values.size();
  if (count < 6 || words.error_share() > 0.007) return;
  // A pulse on a line at rest has no 0 among its data.
  const unsigned ones = (1U << (words.length_bits - 2U)) - 1U;
  if (share_of(words.values, [&](unsigned value) { return value != ones; }) < 0.5) return;
  const bool summed = ends_with_sum(words);
  const bool encoder = is_encoder_rate(grid.bit) && (summed || words.length_bits == 18);
  const std::set<unsigned> different(words.values.begin(), words.values.end());
  if (!encoder && different.size() < (count < 40 ? 3U : 5U)) return;
  guesses.push_back({encoder ? Protocol::serial_encoder : Protocol::uart,
                     trust * (encoder       ? 0.95
                              : count >= 12 ? 0.9
                                            : 0.65),
                     fmt::format("{} words of {} bits at {:.0f} kBd, {} without a stop bit{}",
                                 count, words.length_bits, 1e9 / grid.bit, words.wrong,
                                 summed ? ", answers end with their checksum" : "")});
}

// Most of the rising or of the falling edges come at one interval: a timer, not noise.
bool is_periodic(const std::vector<double>& intervals) {
  for (const std::size_t first : {0U, 1U}) {
    std::vector<double> periods;
    for (std::size_t i = first; i + 1 < intervals.size(); i += 2) {
      periods.push_back(intervals[i] + intervals[i + 1]);
    }
    if (share_near_median(periods, 0.05 * median_of(periods)) > 0.7) return true;
  }
  return false;
}

// Changes that no bit time and no period explains.
void try_noise(const Trace& line, const std::vector<double>& intervals, const Grid& grid,
               double sample, Guesses& guesses) {
  if (intervals.size() < 12) return;
  const bool coarse = grid.bit < 6 * sample;
  const bool scattered = grid.off > 0.17 || coarse;
  if (!scattered || is_periodic(intervals)) return;
  guesses.push_back(
      {Protocol::noise, coarse ? 0.6 : 0.75,
       fmt::format("{} changes without a common period or bit time", line.changes.size())});
}

}  // namespace

void try_serial(const Scene& scene, Guesses& guesses) {
  std::size_t busy = 0;
  Guesses noise;
  for (const Trace& line : scene.lines) {
    if (line.changes.size() < 12) continue;
    ++busy;
    // A clock changes more often than its data; a line that enables a driver does not.
    const bool clocked =
        std::any_of(scene.lines.begin(), scene.lines.end(), [&](const Trace& each) {
          return each.clock.regular >= clock_share && each.changes.size() > line.changes.size();
        });
    if (line.clock.regular >= clock_share) continue;
    std::vector<double> intervals;
    for (std::size_t i = 0; i + 1 < std::min(line.changes.size(), intervals_used); ++i) {
      intervals.push_back(line.interval(i));
    }
    const Grid grid = grid_of(intervals);
    try_dsl(line, intervals, grid, guesses);
    // Data next to a clock has a grid as well.
    try_words(line, grid, scene, clocked ? 0.4 : 1, guesses);
    try_noise(line, intervals, grid, scene.sample, noise);
  }
  if (noise.size() == busy) guesses.insert(guesses.end(), noise.begin(), noise.end());
}

}  // namespace biss::identify
