#include "archive/entry.hpp"

#include <algorithm>
#include <limits>

namespace biss::archive {

using decode::Distribution;

Histogram::Histogram(const Distribution& values) : count_(values.count()) {
  if (count_ == 0) return;
  min_ = values.min();
  max_ = values.max();
  values.for_each_bucket(
      [this](std::int64_t begin, std::uint64_t count) { buckets_[begin] += count; });
}

void Histogram::add(const Histogram& other) {
  if (other.count_ == 0) return;
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = std::max(max_, other.max_);
  count_ += other.count_;
  for (const auto& [begin, count] : other.buckets_) buckets_[begin] += count;
}

std::int64_t Histogram::median() const {
  const std::uint64_t rank = (count_ - 1) / 2;
  std::uint64_t below = 0;
  auto at = buckets_.begin();
  while (below + at->second <= rank) below += (at++)->second;
  return std::clamp(Distribution::bucket_middle(at->first), min_, max_);
}

bool Histogram::assign(const std::vector<Bucket>& buckets, std::int64_t min, std::int64_t max) {
  std::uint64_t count = 0;
  std::int64_t before = -1;
  for (const auto& [begin, values] : buckets) {
    if (begin <= before || Distribution::bucket_begin(begin) != begin) return false;
    if (values == 0 || values > std::numeric_limits<std::uint64_t>::max() - count) return false;
    before = begin;
    count += values;
  }
  const bool fits = buckets.empty()
                        ? min == 0 && max == 0
                        : min >= 0 && min <= max &&
                              Distribution::bucket_begin(min) == buckets.front().first &&
                              Distribution::bucket_begin(max) == buckets.back().first;
  if (!fits) return false;
  buckets_ = {buckets.begin(), buckets.end()};
  count_ = count;
  min_ = min;
  max_ = max;
  return true;
}

}  // namespace biss::archive
