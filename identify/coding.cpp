#include "identify/coding.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "biss/base/bits.hpp"
#include "identify/log_gamma.hpp"

namespace biss::identify {

namespace {

// A value after a longer gap is written down without a prediction.
constexpr double longest_gap = 16;
// Points and degree of the polynomial through the values before; the first predictor is 0, the
// second one the value before.
struct Curve {
  std::size_t points;
  std::size_t degree;
};
constexpr std::array<Curve, Timeline::predictors> curves{
    {{0, 0}, {1, 0}, {2, 1}, {3, 2}, {5, 1}, {16, 1}, {9, 2}}};

double log2_gamma(double x) { return log_gamma(x) / std::log(2.0); }

std::int64_t as_signed(std::uint64_t value, unsigned bits) {
  if (bits == 0) return 0;
  const unsigned unused = 64 - bits;
  return static_cast<std::int64_t>(value << unused) >> unused;
}

// A value, and how often it occurs.
struct Count {
  std::int64_t value = 0;
  double frames = 0;
};

std::vector<Count> counts_of(std::span<const std::int64_t> values) {
  // A table in which a value whose place is taken goes to the next place.
  const std::size_t mask = std::bit_ceil(2 * values.size() + 1) - 1;
  std::vector<Count> table(mask + 1);
  for (const std::int64_t value : values) {
    std::size_t at = (static_cast<std::uint64_t>(value) * 0x9E3779B97F4A7C15U >> 40U) & mask;
    while (table[at].frames != 0 && table[at].value != value) at = (at + 1) & mask;
    table[at].value = value;
    ++table[at].frames;
  }
  std::erase_if(table, [](const Count& each) { return each.frames == 0; });
  return table;
}

unsigned size_of(std::int64_t value) {
  // Subtracted without a sign: the smallest value has no negative.
  const auto bits = static_cast<std::uint64_t>(value);
  return static_cast<unsigned>(std::bit_width(value < 0 ? 0 - bits : bits));
}

// A dictionary that learns: values that occurred before occur again (a Dirichlet process).
double dictionary_cost(const std::vector<Count>& counts, double frames, unsigned bits) {
  constexpr double concentration = 1;
  double cost = log2_gamma(concentration + frames) - log2_gamma(concentration);
  for (const Count& each : counts) cost += bits - (each.frames > 2 ? log2_gamma(each.frames) : 0);
  return cost;
}

// How many values have each size.
using Sizes = std::array<double, 65>;

// The size is learned, the digits are free.
double size_cost(const Sizes& sizes, double frames, unsigned bits) {
  double cost = log2_gamma(frames + (bits + 1) / 2.0) - log2_gamma((bits + 1) / 2.0);
  for (unsigned size = 0; size <= bits; ++size) {
    cost += sizes[size] * size;
    if (sizes[size] != 0) cost += log2_gamma(0.5) - log2_gamma(sizes[size] + 0.5);
  }
  return cost;
}

// A bell curve with few values outside, whose width is near the size of most values.
double bell_cost(const std::vector<Count>& counts, const Sizes& sizes, double frames,
                 unsigned bits) {
  double left = 0.68 * frames;
  unsigned size = 0;
  while (size < 64 && left > sizes[size]) left -= sizes[size++];
  double best = HUGE_VAL;
  for (const double step : {0.35, 0.5, 0.71, 1.0}) {
    const double width = step * std::exp2(size);
    const double factor = 0.5 / (width * width);
    double sum = width < 2 ? 1 : std::sqrt(2 * M_PI) * width;
    for (int k = 1; width < 2 && k < 16; ++k) sum += 2 * std::exp(-factor * k * k);
    const double middle = std::log2(sum);
    double cost = 0;
    for (const Count& each : counts) {
      const auto value = static_cast<double>(each.value);
      const double inside = middle + factor * value * value / std::log(2.0);
      cost += each.frames * std::min(inside, bits + 8.0);
    }
    best = std::min(best, cost);
  }
  return best + std::log2(2.0 * bits);
}

double residuals_cost(std::span<const std::int64_t> residuals, unsigned bits) {
  if (residuals.empty()) return 0;
  const std::vector<Count> counts = counts_of(residuals);
  Sizes sizes{};
  for (const Count& each : counts) sizes[size_of(each.value)] += each.frames;
  const auto frames = static_cast<double>(residuals.size());
  const std::array costs{dictionary_cost(counts, frames, bits), size_cost(sizes, frames, bits),
                         bell_cost(counts, sizes, frames, bits)};
  return cost_of_any(costs) + std::log2(3.0);
}

// The value is far from both its neighbours, which are near each other.
bool stands_apart(std::uint64_t before, std::uint64_t value, std::uint64_t after, unsigned bits) {
  constexpr unsigned times = 4;  // a power of two
  const unsigned between = size_of(as_signed(after - before, bits));
  const unsigned away =
      std::min(size_of(as_signed(value - before, bits)), size_of(as_signed(after - value, bits)));
  return away > between + times && away > 6;
}

// Least squares: the weights of values at `times`, for the value of a polynomial at 0.
std::vector<double> extrapolation(std::span<const double> times, std::size_t degree) {
  std::array<std::array<double, 4>, 3> rows{};
  const std::size_t size = std::min(degree + 1, times.size());
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j < size; ++j) {
      for (const double time : times) rows[i][j] += std::pow(time, static_cast<double>(i + j));
    }
  }
  rows[0][3] = 1;
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < size; ++k) {
      if (k == i) continue;
      const double factor = rows[k][i] / rows[i][i];
      for (std::size_t j = 0; j < 4; ++j) rows[k][j] -= factor * rows[i][j];
    }
  }
  std::vector<double> weights;
  for (const double time : times) {
    double weight = 0;
    for (std::size_t i = 0; i < size; ++i) {
      weight += rows[i][3] / rows[i][i] * std::pow(time, static_cast<double>(i));
    }
    weights.push_back(weight);
  }
  return weights;
}

// How often a bit is 1, and how often it changes.
struct Changes {
  double ones = 0;
  double from[2][2] = {};
};

Changes changes_of(std::span<const std::uint8_t> bits) {
  Changes changes;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    changes.ones += bits[i];
    if (i > 0) ++changes.from[bits[i - 1]][bits[i]];
  }
  return changes;
}

// Runs, which rarely begin.
double runs_cost(const Changes& changes, double begin_a, double begin_b) {
  const auto& from = changes.from;
  return 1 + events_cost(from[0][1], from[0][0] + from[0][1], begin_a, begin_b) +
         events_cost(from[1][0], from[1][0] + from[1][1], 0.5, 2);
}

}  // namespace

double events_cost(double ones, double count, double a, double b) {
  const auto log2_beta = [](double x, double y) {
    return log2_gamma(x) + log2_gamma(y) - log2_gamma(x + y);
  };
  return log2_beta(a, b) - log2_beta(a + ones, b + count - ones);
}

double cost_of_any(std::span<const double> costs) {
  const double least = *std::min_element(costs.begin(), costs.end());
  if (std::isinf(least)) return least;
  double sum = 0;
  for (const double cost : costs) sum += std::exp2(least - cost);
  return least - std::log2(sum);
}

Timeline::Timeline(const std::vector<double>& requests) {
  std::size_t near = 0;
  for (std::size_t i = 0; i < requests.size(); ++i) {
    near = i > 0 && requests[i] - requests[i - 1] <= longest_gap ? near + 1 : 0;
    begins_.push_back(near == 0);
    for (std::size_t p = 2; p < predictors; ++p) {
      std::vector<double> times;
      for (std::size_t k = 1; k <= std::min(near, curves[p].points); ++k) {
        times.push_back(requests[i - k] - requests[i]);
      }
      const auto [known, made] = extrapolations_.try_emplace({curves[p].degree, times});
      if (made) known->second = extrapolation(times, curves[p].degree);
      weights_[p].push_back(&known->second);
    }
  }
}

double Timeline::rough_cost(std::span<const std::uint64_t> values, unsigned bits) {
  double steps = 0;
  double changes = 0;
  for (std::size_t i = 2; i < values.size(); ++i) {
    const std::uint64_t step = values[i] - values[i - 1];
    steps += size_of(as_signed(step, bits));
    changes += size_of(as_signed(step - values[i - 1] + values[i - 2], bits));
  }
  return std::min(steps, changes);
}

double Timeline::cost(std::span<const std::uint64_t> values, unsigned bits) const {
  // Without the jumps at a wrap-around of the value, and without single values that stand apart.
  std::vector<std::uint64_t> path(values.begin(), values.end());
  std::vector<bool> apart(values.size());
  std::size_t unpredicted = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) {
      apart[i] = !begins_[i] && i + 1 < values.size() && !begins_[i + 1] &&
                 stands_apart(path[i - 1], values[i], values[i + 1], bits);
      const std::uint64_t to = apart[i] ? values[i + 1] : values[i];
      const std::int64_t way = as_signed(to - path[i - 1], bits);
      path[i] = path[i - 1] + static_cast<std::uint64_t>(apart[i] ? way / 2 : way);
    }
    unpredicted += begins_[i] || apart[i] ? 1U : 0U;
  }
  std::array<std::vector<std::int64_t>, predictors> residuals;
  std::array<std::pair<double, std::size_t>, predictors> rough;
  for (std::size_t p = 0; p < predictors; ++p) {
    residuals[p].reserve(values.size());
    double sizes = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (begins_[i] || apart[i]) continue;
      std::uint64_t expected = p == 0 ? 0 : path[i - 1];
      if (p > 1) {
        const std::vector<double>& weights = *weights_[p][i];
        double offset = 0;
        for (std::size_t k = 1; k < weights.size(); ++k) {
          offset += weights[k] *
                    static_cast<double>(static_cast<std::int64_t>(path[i - 1 - k] - path[i - 1]));
        }
        expected += static_cast<std::uint64_t>(std::llround(std::clamp(offset, -9e18, 9e18)));
      }
      residuals[p].push_back(as_signed(values[i] - expected, bits));
      sizes += size_of(residuals[p].back());
    }
    rough[p] = {p < 2 ? 0 : sizes, p};
  }
  // The predictors with the smallest residuals, and the simple ones.
  std::sort(rough.begin(), rough.end());
  std::array<double, 4> costs{};
  for (std::size_t k = 0; k < costs.size(); ++k) {
    costs[k] = residuals_cost(residuals[rough[k].second], bits);
  }
  const double first = bits;
  const double later =
      static_cast<double>(unpredicted - 1) * bits + cost_of_any(costs) + std::log2(7.0);
  return first + data_weight * later;
}

bool is_random(std::span<const std::uint8_t> bits) {
  const Changes changes = changes_of(bits);
  const auto is_half = [](double part, double all) {
    return std::abs(part - all / 2) < std::max(0.1 * all, 1.5 * std::sqrt(all));
  };
  const auto count = static_cast<double>(bits.size());
  return is_half(changes.ones, count) &&
         is_half(changes.from[0][1] + changes.from[1][0], count - 1);
}

double flag_cost(std::span<const std::uint8_t> active) {
  const Changes changes = changes_of(active);
  const auto count = static_cast<double>(active.size());
  const double runs = runs_cost(changes, 0.3, 10);
  const double rare = events_cost(changes.ones, count, 0.4, 2);
  const double any = events_cost(changes.ones, count, 1, 1);
  const std::array costs{changes.ones == 0 ? 0.2 : HUGE_VAL, changes.ones == count ? 5 : HUGE_VAL,
                         3.5 + data_weight * runs, 4.5 + data_weight * rare,
                         7.5 + data_weight * any};
  // A flag that is active in most frames may have the other polarity.
  const bool most = 2 * changes.ones > count && changes.ones < count;
  return cost_of_any(costs) + (most ? 1 : 0);
}

double padding_cost(std::span<const std::uint8_t> bits) {
  const Changes changes = changes_of(bits);
  if (changes.ones == 0) return 0.3;
  if (changes.ones == static_cast<double>(bits.size())) return 3;
  return 6 + data_weight * runs_cost(changes, 0.5, 0.5);
}

double counter_cost(std::span<const CounterValue> values, unsigned bits) {
  // A frame that is lost or repeated costs fewer bits than any value.
  constexpr std::uint64_t few = 4;
  constexpr unsigned near_bits = 3;
  const auto count = static_cast<double>(values.size() - 1);
  double best = HUGE_VAL;
  for (const std::uint64_t first : {0U, 1U}) {
    const std::uint64_t modulus = low_mask(bits) + 1 - first;
    const auto follows = [&](const CounterValue& now, const CounterValue& before,
                             std::uint64_t steps) {
      return before.value >= first && now.value == (before.value - first + steps) % modulus + first;
    };
    // The last value that followed at its cycle: a late value does not change the next one.
    CounterValue last = values[0];
    double exceptions = 0;
    double cost = 0;
    for (std::size_t i = 1; i < values.size(); ++i) {
      const CounterValue& now = values[i];
      const CounterValue& before = values[i - 1];
      const std::uint64_t steps = now.cycle - before.cycle;
      // If a request is not answered, an encoder need not count.
      cost += steps <= now.repeats_before + 1 ? 0 : 1;
      if (follows(now, before, steps) || follows(now, last, now.cycle - last.cycle)) {
        last = now;
      } else if (!follows(now, before, 1)) {
        const std::uint64_t step = (now.value - before.value) & low_mask(bits);
        cost += step <= few ? std::min(bits, near_bits) : bits;
        ++exceptions;
      }
    }
    best = std::min(best, cost + events_cost(exceptions, count, 0.3, 3));
  }
  return bits + 1 + data_weight * best;
}

double word_cost(std::span<const std::uint64_t> words, unsigned bits) {
  const std::vector<std::int64_t> values(words.begin(), words.end());
  return bits +
         data_weight *
             (dictionary_cost(counts_of(values), static_cast<double>(values.size()), bits) - bits);
}

}  // namespace biss::identify
