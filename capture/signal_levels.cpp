// Estimates the low and the high level of a line from its voltages.
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/analog.hpp"

namespace biss::capture {
namespace {

constexpr std::size_t histogram_bins = 1'024;
constexpr std::uint64_t least_samples_of_class = 8;
constexpr Nanovolts least_swing = millivolts(100);
// Distance of the classes in units of the sum of their standard deviations: Gaussian noise, divided
// at its middle, has 1.3; a sine has 2.1; a square wave with slow edges 4 and more.
constexpr double least_separation = 1.6;

// Samples of a signal by voltage.
class Histogram {
 public:
  explicit Histogram(std::vector<Nanovolts> samples) {
    std::erase_if(samples, [](Nanovolts sample) {
      return sample >= over_range || sample <= Nanovolts{-over_range.count};
    });
    if (samples.empty()) return;
    const auto [least, greatest] = std::minmax_element(samples.begin(), samples.end());
    least_ = static_cast<double>(least->count);
    greatest_ = static_cast<double>(greatest->count);
    if (greatest_ <= least_) return;
    for (const Nanovolts sample : samples) {
      const double share = (static_cast<double>(sample.count) - least_) / (greatest_ - least_);
      const auto bin = static_cast<std::size_t>(share * (histogram_bins - 1) + 0.5);
      ++counts_[std::min(bin, histogram_bins - 1)];
    }
  }

  double swing() const { return greatest_ - least_; }
  Nanovolts voltage(std::size_t bin) const {
    const double above = static_cast<double>(bin) * (greatest_ - least_);
    return Nanovolts{std::llround(least_ + above / (histogram_bins - 1))};
  }
  const std::array<std::uint64_t, histogram_bins>& counts() const { return counts_; }

 private:
  double least_ = 0;
  double greatest_ = 0;
  std::array<std::uint64_t, histogram_bins> counts_{};
};

// The bins first…end of a histogram.
struct SampleClass {
  double count = 0;
  double mean = 0;
  double deviation = 0;
  std::size_t median = 0;
};

SampleClass class_of(const Histogram& histogram, std::size_t first, std::size_t end) {
  SampleClass result;
  double sum = 0;
  double squares = 0;
  for (std::size_t bin = first; bin < end; ++bin) {
    const auto n = static_cast<double>(histogram.counts()[bin]);
    const auto at = static_cast<double>(bin);
    result.count += n;
    sum += n * at;
    squares += n * at * at;
  }
  if (result.count == 0) return result;
  result.mean = sum / result.count;
  result.deviation = std::sqrt(std::max(0.0, squares / result.count - result.mean * result.mean));
  double below = 0;
  for (result.median = first; result.median + 1 < end; ++result.median) {
    below += static_cast<double>(histogram.counts()[result.median]);
    if (2 * below >= result.count) break;
  }
  return result;
}

// The beginning of the upper class: the division with the largest variance between the classes.
std::size_t division_of(const Histogram& histogram) {
  double all = 0;
  double all_sum = 0;
  for (std::size_t bin = 0; bin < histogram_bins; ++bin) {
    const auto n = static_cast<double>(histogram.counts()[bin]);
    all += n;
    all_sum += n * static_cast<double>(bin);
  }
  double count = 0;
  double sum = 0;
  double best = -1;
  std::size_t division = 1;
  for (std::size_t bin = 0; bin + 1 < histogram_bins; ++bin) {
    const auto n = static_cast<double>(histogram.counts()[bin]);
    count += n;
    sum += n * static_cast<double>(bin);
    if (count == 0 || count == all) continue;
    const double distance = sum / count - (all_sum - sum) / (all - count);
    const double between = count * (all - count) * distance * distance;
    if (between <= best) continue;
    best = between;
    division = bin + 1;
  }
  return division;
}

}  // namespace

std::optional<SignalLevels> estimate_levels(std::span<const Nanovolts> samples) {
  const Histogram histogram({samples.begin(), samples.end()});
  if (histogram.swing() < static_cast<double>(least_swing.count)) return std::nullopt;
  const std::size_t division = division_of(histogram);
  const SampleClass low = class_of(histogram, 0, division);
  const SampleClass high = class_of(histogram, division, histogram_bins);
  if (std::min(low.count, high.count) < static_cast<double>(least_samples_of_class)) {
    return std::nullopt;
  }
  if (high.mean - low.mean < least_separation * (low.deviation + high.deviation)) {
    return std::nullopt;
  }
  const SignalLevels levels{histogram.voltage(low.median), histogram.voltage(high.median)};
  if (levels.high.count - levels.low.count < least_swing.count) return std::nullopt;
  return levels;
}

}  // namespace biss::capture
