// Lines without a clock: UART, encoders that use UART words, HIPERFACE DSL, noise.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "identify/protocol_trials.hpp"

namespace biss::identify {

namespace {

constexpr std::size_t intervals_used = 4'000;
constexpr std::size_t words_used = 400;
constexpr double nanosecond = 1e3;

// The line as bits of one length.
struct Grid {
  double bit = 0;
  // Mean distance of the intervals of up to ten bits from whole bits, in bits.
  double off = 1;
  // Share of the intervals that are not shorter than half a bit.
  double whole = 0;
  std::size_t longest_run = 0;
  // Share of the intervals of more than five bits.
  double long_share = 0;
};

std::vector<double> intervals_of(const Trace& line) {
  std::vector<double> intervals;
  for (std::size_t i = 0; i + 1 < std::min(line.changes.size(), intervals_used); ++i) {
    intervals.push_back(line.interval(i));
  }
  return intervals;
}

Grid grid_of(const Trace& line) {
  Grid grid;
  const std::vector<double> intervals = intervals_of(line);
  if (intervals.size() < 8) return grid;
  std::vector<double> sorted = intervals;
  std::sort(sorted.begin(), sorted.end());
  const double shortest = sorted[std::min(sorted.size() - 1, sorted.size() / 50 + 1)];
  double bit = 0;
  double count = 0;
  for (const double value : sorted) {
    if (value < 0.7 * shortest || value > 1.5 * shortest) continue;
    bit += value;
    ++count;
  }
  if (count == 0) return grid;
  bit /= count;
  if (!(bit > 0)) return grid;
  for (int pass = 0; pass < 3; ++pass) {
    double time = 0;
    double bits = 0;
    for (const double value : intervals) {
      const double whole = std::round(value / bit);
      if (whole < 1 || whole > 9) continue;
      time += value;
      bits += whole;
    }
    if (bits == 0) return grid;
    bit = time / bits;
  }
  // Not where all edges are at one time.
  if (!(bit > 0)) return grid;
  grid.bit = bit;
  double off = 0;
  double measured = 0;
  double half = 0;
  double longer = 0;
  for (const double value : intervals) {
    const double bits = value / bit;
    half += bits >= 0.5 ? 1 : 0;
    longer += bits > 5.5 ? 1 : 0;
    grid.longest_run =
        std::max(grid.longest_run, static_cast<std::size_t>(std::min(bits + 0.5, 1e6)));
    if (bits > 9.5) continue;
    off += std::abs(bits - std::round(bits));
    ++measured;
  }
  const auto all = static_cast<double>(intervals.size());
  grid.off = measured == 0 ? 1 : off / measured;
  grid.whole = half / all;
  grid.long_share = longer / all;
  return grid;
}

// Words of a start bit, data and a stop bit.
struct Words {
  unsigned length_bits = 0;
  std::size_t count = 0;
  std::size_t wrong = 0;
  // With a 0 among the data; a pulse on a line at rest has none.
  std::size_t filled = 0;
  std::set<unsigned> values;
  // Data bytes, for words of ten bits, with a gap before the first one of each group.
  std::vector<std::vector<unsigned>> groups;

  double error_share() const {
    return count == 0 ? 1 : static_cast<double>(wrong) / static_cast<double>(count);
  }
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
  Words words{.length_bits = length_bits, .values = {}, .groups = {}};
  const bool idle = idles_high(line, bit);
  std::size_t at = 0;
  // Begins after a gap, if there is one: before it the place in a word is not known.
  for (std::size_t i = 0; i + 1 < std::min<std::size_t>(line.changes.size(), 200); ++i) {
    if (line.interval(i) > length_bits * bit && line.level_before(i + 1) == idle) {
      at = i + 1;
      break;
    }
  }
  Picoseconds last_stop{};
  while (at < line.changes.size() && words.count < words_used) {
    if (line.level_before(at) != idle) {
      ++at;
      continue;
    }
    const Picoseconds start = line.changes[at];
    const auto moment = [&](double bits) {
      return decode::shifted(start, Picoseconds{static_cast<std::int64_t>(bits * bit)});
    };
    const Picoseconds stop = moment(length_bits - 0.5);
    if (stop > end) break;
    unsigned value = 0;
    for (unsigned k = 1; k + 1 < length_bits; ++k) {
      if (line.level_at(moment(k + 0.5)) == idle) value |= 1U << (k - 1U);
    }
    ++words.count;
    words.values.insert(value);
    if (value + 1U != 1U << (length_bits - 2U)) ++words.filled;
    if (line.level_at(stop) != idle) ++words.wrong;
    if (words.groups.empty() || length(last_stop, start) > 3 * bit) words.groups.emplace_back();
    words.groups.back().push_back(value);
    last_stop = stop;
    at = line.after(stop);
    if (line.level_at(stop) != idle) {
      // Waits for idle again.
      ++at;
    }
  }
  return words;
}

bool is_encoder_rate(double bit) {
  constexpr std::array<double, 5> bits{400, 250, 200, 125, 62.5};
  return std::any_of(bits.begin(), bits.end(), [&](double nanoseconds) {
    return std::abs(bit - nanoseconds * nanosecond) < 0.03 * nanoseconds * nanosecond;
  });
}

// The shortest words that fit best.
Words best_words(const Trace& line, double bit, Picoseconds end) {
  Words best;
  if (is_encoder_rate(bit)) {
    Words words = read_words(line, bit, 18, end);
    if (words.count >= 20 && words.wrong == 0) return words;
  }
  for (const unsigned length_bits : {10U, 11U, 9U, 12U, 8U, 7U}) {
    Words words = read_words(line, bit, length_bits, end);
    if (best.count == 0 || words.error_share() < best.error_share() - 0.004)
      best = std::move(words);
  }
  return best;
}

// The answer of a Tamagawa or Panasonic encoder ends with the sum of all its bytes without carry.
double summed_share(const Words& words) {
  std::size_t answers = 0;
  std::size_t good = 0;
  for (const auto& group : words.groups) {
    if (group.size() < 4) continue;
    // The request may come right before its answer.
    for (std::size_t from = 0; from < 2; ++from) {
      unsigned sum = 0;
      for (std::size_t i = from; i < group.size(); ++i) sum ^= group[i];
      const bool plain = std::all_of(group.begin(), group.end(), [](unsigned b) { return b == 0; });
      if (sum == 0 && !plain) {
        ++good;
        break;
      }
    }
    ++answers;
  }
  return answers < 3 ? 0 : static_cast<double>(good) / static_cast<double>(answers);
}

ProtocolGuess dsl_of(const Trace& line, const Grid& grid) {
  ProtocolGuess guess{Protocol::hiperface_dsl, 0, "", line.line, line.line, false};
  constexpr double dsl_bit = 1e6 / 9.375;  // ps
  const bool rate = std::abs(grid.bit - dsl_bit * 1e0) < 0.02 * dsl_bit;
  if (!rate || line.changes.size() < 300 || grid.long_share > 0.005 || grid.off > 0.25)
    return guess;
  guess.confidence = 0.95;
  guess.why = fmt::format("{:.3f} Mbit/s, {} changes, never more than {} equal bits",
                          1e6 / grid.bit, line.changes.size(), grid.longest_run);
  return guess;
}

ProtocolGuess words_of(const Trace& line, const Grid& grid, const Scene& scene) {
  ProtocolGuess guess{Protocol::uart, 0, "", line.line, line.line, false};
  const double coarse = 0.1 + 0.5 * scene.sample() / std::max(grid.bit, 1.0);
  if (grid.bit <= 0 || grid.bit < 2.5 * scene.sample() || grid.off > coarse || grid.whole < 0.97)
    return guess;
  const Words words = best_words(line, grid.bit, scene.end);
  if (words.count < 6 || words.error_share() > 0.007) return guess;
  if (2 * words.filled < words.count) return guess;
  const double summed = words.length_bits == 10 ? summed_share(words) : 0;
  const bool encoder_rate = is_encoder_rate(grid.bit);
  const bool encoder = encoder_rate && (summed > 0.8 || words.length_bits == 18);
  if (!encoder && words.values.size() < (words.count < 40 ? 3U : 5U)) return guess;
  guess.protocol = encoder ? Protocol::serial_encoder : Protocol::uart;
  guess.confidence = encoder ? 0.95 : words.count >= 12 ? 0.9 : 0.65;
  guess.why = fmt::format("{} words of {} bits at {:.0f} kBd, {} without a stop bit{}", words.count,
                          words.length_bits, 1e9 / grid.bit, words.wrong,
                          summed > 0.8 ? ", answers end with their checksum" : "");
  return guess;
}

// Most of the rising or of the falling edges come at one interval: a timer, not noise.
bool is_periodic(const Trace& line) {
  for (const std::size_t first : {0U, 1U}) {
    std::vector<double> periods;
    for (std::size_t i = first; i + 2 < std::min(line.changes.size(), intervals_used); i += 2) {
      periods.push_back(length(line.changes[i], line.changes[i + 2]));
    }
    if (share_near_median(periods, 0.05 * median_of(periods)) > 0.7) return true;
  }
  return false;
}

// Changes that no bit time and no period explains.
ProtocolGuess noise_of(const Scene& scene, const Trace& line, const Grid& grid) {
  ProtocolGuess guess{Protocol::noise, 0, "", line.line, line.line, false};
  const std::vector<double> intervals = intervals_of(line);
  if (intervals.size() < 12) return guess;
  double mean = 0;
  double square = 0;
  for (const double value : intervals) {
    const double size = std::log(std::max(value, 1.0));
    mean += size;
    square += size * size;
  }
  const auto count = static_cast<double>(intervals.size());
  mean /= count;
  const double spread = std::sqrt(std::max(0.0, square / count - mean * mean));
  const bool coarse = grid.bit < 6 * scene.sample();
  const bool scattered = grid.off > 0.17 || coarse || grid.whole < 0.9;
  if (!scattered || spread < 0.5 || is_periodic(line)) return guess;
  guess.confidence = coarse ? 0.6 : 0.75;
  guess.why = fmt::format("{} changes in no period and no bit time", line.changes.size());
  return guess;
}

}  // namespace

namespace {

// A clock changes more often than its data; a line that enables a driver does not.
bool has_clock(const Scene& scene, const Trace& data) {
  for (std::size_t i = 0; i < scene.traces.size(); ++i) {
    if (scene.clocks[i].regular < clock_share) continue;
    if (scene.traces[i].changes.size() > data.changes.size()) return true;
  }
  return false;
}

}  // namespace

Guesses try_serial(const Scene& scene) {
  Guesses guesses;
  bool any_clock = false;
  std::size_t noisy = 0;
  ProtocolGuess noise{Protocol::noise, 0, "", 0, 0, false};
  std::size_t busy = 0;
  for (const Trace& line : scene.traces) {
    const auto index = static_cast<std::size_t>(&line - scene.traces.data());
    if (line.changes.size() < 12) continue;
    ++busy;
    const bool clocked = has_clock(scene, line);
    any_clock = any_clock || clocked;
    if (scene.clocks[index].regular >= clock_share) continue;
    const Grid grid = grid_of(line);
    guesses.push_back(dsl_of(line, grid));
    ProtocolGuess words = words_of(line, grid, scene);
    // Beside a clock, data has a grid as well.
    if (clocked) words.confidence *= 0.4;
    guesses.push_back(std::move(words));
    ProtocolGuess scattered = noise_of(scene, line, grid);
    if (scattered.confidence > 0) {
      ++noisy;
      if (scattered.confidence > noise.confidence) noise = std::move(scattered);
    }
  }
  if (!any_clock && noisy == busy && busy != 0) guesses.push_back(std::move(noise));
  return guesses;
}

}  // namespace biss::identify
