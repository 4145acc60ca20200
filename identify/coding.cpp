#include "identify/coding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "biss/base/bits.hpp"

namespace biss::identify {

namespace {

// The lowest `gray_bits` decoded, the bits above as they are.
std::uint64_t decoded(std::uint64_t value, unsigned gray_bits) {
  const std::uint64_t mask = low_mask(gray_bits);
  std::uint64_t gray = value & mask;
  for (unsigned shift = 1; shift < gray_bits; shift *= 2) gray ^= gray >> shift;
  return (value & ~mask) | gray;
}

// Distance to zero around the circle of 2^bits values.
double distance(std::uint64_t value, unsigned bits) {
  const unsigned unused = 64 - bits;
  const auto signed_value = static_cast<std::int64_t>(value << unused) >> unused;
  return std::abs(static_cast<double>(signed_value));
}

// Whether `shorter` is shorter than `longer` by more than chance does.
bool clearly_shorter(const std::vector<double>& shorter, const std::vector<double>& longer) {
  constexpr double least_bits = 24;
  constexpr double least_deviations = 5;
  const auto count = static_cast<double>(shorter.size());
  double mean = 0;
  double square = 0;
  for (std::size_t i = 0; i < shorter.size(); ++i) {
    const double gain = longer[i] - shorter[i];
    mean += gain / count;
    square += gain * gain / count;
  }
  const double deviation = std::sqrt(std::max(square - mean * mean, 1e-9) * count);
  return mean * count > least_bits && mean * count > least_deviations * deviation;
}

}  // namespace

std::uint64_t Bits::mask() const { return low_mask(count) << low; }

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

std::vector<double> step_lengths(std::span<const DataWord> words, Bits bits, unsigned gray_bits) {
  std::vector<double> steps;
  std::vector<double> changes;
  const std::uint64_t mask = low_mask(bits.count);
  std::uint64_t value[3] = {};
  for (std::size_t i = 0; i < words.size(); ++i) {
    value[0] = value[1];
    value[1] = value[2];
    value[2] = decoded(bits.of(words[i].data), gray_bits);
    if (i < 2 || words[i].cycle - words[i - 2].cycle != 2) continue;
    const std::uint64_t step = value[2] - value[1];
    const std::uint64_t before = value[1] - value[0];
    steps.push_back(std::log2(1 + 2 * distance(step & mask, bits.count)));
    changes.push_back(std::log2(1 + 2 * distance((step - before) & mask, bits.count)));
  }
  return sum(changes) < sum(steps) ? changes : steps;
}

Coding find_coding(std::span<const DataWord> words, Bits bits) {
  const std::vector<double> binary = step_lengths(words, bits, 0);
  if (binary.size() < 8 || bits.count < 2) return {};
  Coding coding;
  std::vector<double> best = binary;
  std::vector<std::vector<double>> all{binary};
  for (unsigned gray_bits = bits.count; gray_bits >= std::min(least_gray_bits, bits.count);
       --gray_bits) {
    all.push_back(step_lengths(words, bits, gray_bits));
    if (sum(all.back()) < sum(best) && clearly_shorter(all.back(), binary)) {
      best = all.back();
      coding.gray_bits = gray_bits;
    }
  }
  // Steps of any size would take this many bits.
  const double any = std::max(0.0, bits.count - 1 / std::log(2.0));
  coding.sure = clearly_shorter(best, std::vector<double>(best.size(), any)) &&
                std::all_of(all.begin(), all.end(), [&](const std::vector<double>& each) {
                  return each == best || clearly_shorter(best, each);
                });
  return coding;
}

}  // namespace biss::identify
