#include "archive/histogram.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

namespace biss::archive {

using decode::Distribution;

Histogram::Histogram(const Distribution& values) : count_(values.count()) {
  if (count_ == 0) return;
  min_ = values.min();
  max_ = values.max();
  std::map<std::int64_t, std::uint64_t> sorted;
  values.for_each_bucket([&](std::int64_t begin, std::uint64_t count) { sorted[begin] += count; });
  for (const auto& [begin, count] : sorted) buckets_.push_back({begin, count});
}

void Histogram::add(const Histogram& other) {
  if (other.count_ == 0) return;
  min_ = count_ == 0 ? other.min_ : std::min(min_, other.min_);
  max_ = std::max(max_, other.max_);
  count_ += other.count_;
  std::vector<Bucket> sum;
  sum.reserve(buckets_.size() + other.buckets_.size());
  auto a = buckets_.begin();
  auto b = other.buckets_.begin();
  while (a != buckets_.end() || b != other.buckets_.end()) {
    if (b == other.buckets_.end() || (a != buckets_.end() && a->begin < b->begin)) {
      sum.push_back(*a++);
    } else if (a == buckets_.end() || b->begin < a->begin) {
      sum.push_back(*b++);
    } else {
      sum.push_back({a->begin, a->count + b->count});
      ++a;
      ++b;
    }
  }
  buckets_ = std::move(sum);
}

std::int64_t Histogram::median() const {
  const std::uint64_t rank = (count_ - 1) / 2;
  std::uint64_t below = 0;
  std::size_t at = 0;
  while (below + buckets_[at].count <= rank) below += buckets_[at++].count;
  return std::clamp(Distribution::bucket_middle(buckets_[at].begin), min_, max_);
}

bool Histogram::assign(std::vector<Bucket> buckets, std::int64_t min, std::int64_t max) {
  std::uint64_t count = 0;
  std::int64_t before = -1;
  for (const Bucket& bucket : buckets) {
    if (bucket.begin <= before || Distribution::bucket_begin(bucket.begin) != bucket.begin) {
      return false;
    }
    if (bucket.count == 0 || bucket.count > std::numeric_limits<std::uint64_t>::max() - count) {
      return false;
    }
    before = bucket.begin;
    count += bucket.count;
  }
  const bool fits = buckets.empty()
                        ? min == 0 && max == 0
                        : min >= 0 && min <= max &&
                              Distribution::bucket_begin(min) == buckets.front().begin &&
                              Distribution::bucket_begin(max) == buckets.back().begin;
  if (!fits) return false;
  buckets_ = std::move(buckets);
  count_ = count;
  min_ = min;
  max_ = max;
  return true;
}

}  // namespace biss::archive
