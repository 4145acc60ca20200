// How often each value occurs, in a form that adds up: the buckets of decode::Distribution.
#pragma once

#include <cstdint>
#include <vector>

#include "decode/distribution.hpp"

namespace biss::archive {

/// Non-negative values. Minimum and maximum are exact, the others within 0.1 %. The sum of two
/// histograms is the histogram of the values of both, in any order.
class Histogram {
 public:
  /// The values of a bucket: its smallest possible value, and how many there are.
  struct Bucket {
    std::int64_t begin = 0;
    std::uint64_t count = 0;
    bool operator==(const Bucket&) const = default;
  };

  Histogram() = default;
  explicit Histogram(const decode::Distribution& values);

  bool operator==(const Histogram&) const = default;
  void add(const Histogram& other);

  std::uint64_t count() const { return count_; }
  /// \pre count() > 0
  std::int64_t min() const { return min_; }
  std::int64_t max() const { return max_; }
  /// The lower median. \pre count() > 0
  std::int64_t median() const;

  /// In ascending order.
  const std::vector<Bucket>& buckets() const { return buckets_; }
  /// The histogram of these buckets, as read from a file.
  /// \return false, and nothing changes, if the buckets are not valid: out of order or empty,
  ///   limits outside of the first and the last bucket, more than 2^64 values
  [[nodiscard]] bool assign(std::vector<Bucket> buckets, std::int64_t min, std::int64_t max);

 private:
  std::vector<Bucket> buckets_;
  std::uint64_t count_ = 0;
  std::int64_t min_ = 0;
  std::int64_t max_ = 0;
};

}  // namespace biss::archive
