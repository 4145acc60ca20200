// Minimum, median, spread and maximum of any number of values in bounded memory.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace biss::decode {

/// Non-negative values. Minimum and maximum are always exact; the others are exact up to 65 536
/// values and within 0.1 % beyond: values are then counted in buckets of that width.
class Distribution {
 public:
  void add(std::int64_t value) {
    value = std::max<std::int64_t>(value, 0);
    min_ = count_ == 0 ? value : std::min(min_, value);
    max_ = std::max(max_, value);
    ++count_;
    if (buckets_.empty() && values_.size() < exact_values) {
      // Unused memory costs no time, but moving many values takes time.
      if (values_.size() == many_values) values_.reserve(exact_values);
      values_.push_back(value);
      return;
    }
    if (buckets_.empty()) to_buckets();
    ++buckets_[bucket_of(value)];
  }

  std::uint64_t count() const { return count_; }
  /// \pre count() > 0
  std::int64_t min() const { return min_; }
  std::int64_t max() const { return max_; }
  /// The lower median. \pre count() > 0
  std::int64_t median() const { return at_rank((count_ - 1) / 2); }
  /// The value with a tenth of the others below it. \pre count() > 0
  std::int64_t tenth() const { return at_rank((count_ - 1) / 10); }
  /// From there to the value with a tenth of the others above it. \pre count() > 0
  std::int64_t spread() const { return at_rank(count_ - 1 - (count_ - 1) / 10) - tenth(); }

  /// The smallest value of the bucket that has this value; below 1024 the value itself.
  static std::int64_t bucket_begin(std::int64_t value) {
    return begin_of(bucket_of(std::max<std::int64_t>(value, 0)));
  }
  /// The value that represents the bucket that begins here. \pre `begin` is a bucket_begin()
  static std::int64_t bucket_middle(std::int64_t begin) { return middle_of(bucket_of(begin)); }
  /// Calls visit(begin, count) for buckets with values, in any order, a bucket once or several
  /// times: the counts of a bucket add up.
  template <class Visit>
  void for_each_bucket(Visit visit) const {
    for (const std::int64_t value : values_) visit(bucket_begin(value), std::uint64_t{1});
    for (std::size_t bucket = 0; bucket < buckets_.size(); ++bucket) {
      if (buckets_[bucket] != 0) visit(begin_of(bucket), buckets_[bucket]);
    }
  }

 private:
  static constexpr std::size_t exact_values = std::size_t{1} << 16U;
  static constexpr std::size_t many_values = 1'024;
  static constexpr unsigned mantissa_bits = 10;

  // The value with this many before it in their order.
  std::int64_t at_rank(std::uint64_t rank) const {
    if (buckets_.empty()) {
      std::vector<std::int64_t> sorted = values_;
      const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(rank);
      std::nth_element(sorted.begin(), middle, sorted.end());
      return *middle;
    }
    std::uint64_t below = 0;
    std::size_t bucket = 0;
    while (below + buckets_[bucket] <= rank) below += buckets_[bucket++];
    return std::clamp(middle_of(bucket), min_, max_);
  }

  // Values below 2^10 have a bucket each; above, every power of two has 2^9 buckets.
  static std::size_t bucket_of(std::int64_t value) {
    const auto v = static_cast<std::uint64_t>(value);
    const auto width = static_cast<unsigned>(std::bit_width(v));
    if (width <= mantissa_bits) return static_cast<std::size_t>(v);
    const unsigned shift = width - mantissa_bits;
    return (std::size_t{shift} << (mantissa_bits - 1)) + static_cast<std::size_t>(v >> shift);
  }

  // The number of low bits in which the values of a bucket differ.
  static std::size_t shift_of(std::size_t bucket) {
    constexpr std::size_t half = std::size_t{1} << (mantissa_bits - 1);
    return bucket < 2 * half ? 0 : bucket / half - 1;
  }

  static std::int64_t begin_of(std::size_t bucket) {
    constexpr std::size_t half = std::size_t{1} << (mantissa_bits - 1);
    const std::size_t shift = shift_of(bucket);
    return static_cast<std::int64_t>((bucket - shift * half) << shift);
  }

  static std::int64_t middle_of(std::size_t bucket) {
    return begin_of(bucket) + static_cast<std::int64_t>((std::size_t{1} << shift_of(bucket)) / 2);
  }

  void to_buckets() {
    buckets_.assign(std::size_t{64} << (mantissa_bits - 1), 0);
    for (const std::int64_t value : values_) ++buckets_[bucket_of(value)];
    values_ = {};
  }

  std::vector<std::int64_t> values_;
  std::vector<std::uint64_t> buckets_;
  std::uint64_t count_ = 0;
  std::int64_t min_ = 0;
  std::int64_t max_ = 0;
};

}  // namespace biss::decode
