#include "archive/entry.hpp"

#include <gtest/gtest.h>

#include <random>

namespace biss::archive {
namespace histogram_test {

decode::Distribution distribution(const std::vector<std::int64_t>& values) {
  decode::Distribution sum;
  for (const std::int64_t value : values) sum.add(value);
  return sum;
}

// Values as they occur: a few, close together, far apart, very large.
std::vector<std::int64_t> random_values(std::mt19937_64& random, std::size_t count) {
  std::vector<std::int64_t> values;
  const auto shift = random() % 62 + 1;
  for (std::size_t i = 0; i < count; ++i) {
    values.push_back(static_cast<std::int64_t>(random() >> shift));
  }
  return values;
}

TEST(Histogram, SumOfParts_IsThatOfAllValuesInAnyOrder) {
  std::mt19937_64 random(1);
  for (int round = 0; round < 50; ++round) {
    // Beyond 65 536 values a distribution counts in buckets itself.
    const std::size_t counts[] = {random() % 5, random() % 1'000, round % 10 == 0 ? 70'000U : 3U};
    std::vector<std::int64_t> all;
    Histogram forward;
    Histogram backward;
    std::vector<Histogram> parts;
    for (const std::size_t count : counts) {
      const auto values = random_values(random, count);
      all.insert(all.end(), values.begin(), values.end());
      parts.emplace_back(distribution(values));
    }
    for (std::size_t i = 0; i < parts.size(); ++i) {
      forward.add(parts[i]);
      backward.add(parts[parts.size() - 1 - i]);
    }
    const Histogram whole(distribution(all));
    EXPECT_EQ(forward, whole);
    EXPECT_EQ(backward, whole);
    EXPECT_EQ(whole.count(), all.size());
    const std::int64_t exact = distribution(all).median();
    EXPECT_NEAR(static_cast<double>(whole.median()), static_cast<double>(exact),
                1 + 0.001 * static_cast<double>(exact));
  }
}

TEST(Histogram, BucketsThatNoValuesHave_AreRefused) {
  Histogram histogram(distribution({5, 7, 2'000}));
  const Histogram before = histogram;
  EXPECT_TRUE(Histogram().assign({{5, 1}, {7, 1}, {2'000, 1}}, 5, 2'000));
  EXPECT_FALSE(histogram.assign({{7, 1}, {5, 1}}, 5, 7));
  EXPECT_FALSE(histogram.assign({{5, 1}, {5, 1}}, 5, 5));
  EXPECT_FALSE(histogram.assign({{5, 0}}, 5, 5));
  EXPECT_FALSE(histogram.assign({{5, 1}}, 4, 5));
  EXPECT_FALSE(histogram.assign({{5, 1}}, 5, 6));
  EXPECT_FALSE(histogram.assign({{-5, 1}}, -5, -5));
  EXPECT_FALSE(histogram.assign({}, 0, 1));
  // 2001 is in the bucket that begins at 2000.
  EXPECT_FALSE(histogram.assign({{2'001, 1}}, 2'001, 2'001));
  EXPECT_FALSE(histogram.assign({{1, ~std::uint64_t{0}}, {2, 1}}, 1, 2));
  EXPECT_EQ(histogram, before);
}

}  // namespace histogram_test
}  // namespace biss::archive
