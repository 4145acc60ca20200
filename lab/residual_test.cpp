#include "lab/residual.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>
#include <vector>

#include "lab/weights.hpp"

#include "lab/statistics.hpp"

namespace biss::lab {
namespace residual_test {

struct Listed {
  std::uint32_t polynomial;
  unsigned crc_bits;
  unsigned data_bits;
  long double at_1e2;
  long double at_1e3;
  long double at_1e4;
  long double highest;
};

// error-detection, section 1.
const std::vector<Listed> listed = {
    {0x43, 6, 14, 1.925e-05L, 2.171e-08L, 2.197e-11L, 1.5624e-02L},
    {0x43, 6, 20, 3.376e-05L, 3.933e-08L, 3.993e-11L, 1.5625e-02L},
    {0x43, 6, 26, 6.514e-05L, 7.925e-08L, 8.082e-11L, 1.5625e-02L},
    {0x43, 6, 28, 7.768e-05L, 9.574e-08L, 9.777e-11L, 1.5625e-02L},
    {0x43, 6, 30, 9.281e-05L, 1.161e-07L, 1.187e-10L, 1.5625e-02L},
    {0x43, 6, 34, 1.236e-04L, 1.585e-07L, 1.625e-10L, 1.5625e-02L},
    {0x43, 6, 38, 1.572e-04L, 2.066e-07L, 2.124e-10L, 1.5625e-02L},
    {0x43, 6, 42, 1.999e-04L, 2.698e-07L, 2.781e-10L, 1.5625e-02L},
    {0x43, 6, 50, 3.061e-04L, 4.363e-07L, 4.522e-10L, 1.5625e-02L},
    {0x43, 6, 57, 4.169e-04L, 6.224e-07L, 6.481e-10L, 1.5625e-02L},
    {0x190D9, 16, 20, 3.557e-11L, 4.658e-17L, 4.786e-23L, 1.5259e-05L},
    {0x190D9, 16, 24, 7.690e-11L, 1.044e-16L, 1.076e-22L, 1.5259e-05L},
    {0x190D9, 16, 32, 2.427e-10L, 3.538e-16L, 3.675e-22L, 1.5259e-05L},
    {0x190D9, 16, 36, 3.806e-10L, 5.749e-16L, 5.992e-22L, 1.5259e-05L},
    {0x190D9, 16, 40, 5.750e-10L, 8.999e-16L, 9.413e-22L, 1.5259e-05L},
    {0x190D9, 16, 44, 8.497e-10L, 1.378e-15L, 1.446e-21L, 1.5259e-05L},
    {0x190D9, 16, 48, 1.231e-09L, 2.068e-15L, 2.178e-21L, 1.5259e-05L},
    {0x13, 4, 11, 3.198e-05L, 3.469e-08L, 3.497e-11L, 6.2469e-02L},
    {0x13, 4, 8, 1.588e-05L, 1.689e-08L, 1.699e-11L, 6.2256e-02L},
    {0x197, 8, 28, 3.288e-06L, 4.378e-10L, 4.506e-14L, 3.9062e-03L},
    {0x197, 8, 34, 5.987e-06L, 8.405e-10L, 8.697e-14L, 3.9062e-03L},
    {0x197, 8, 38, 8.448e-06L, 1.228e-09L, 1.276e-13L, 3.9062e-03L},
};

TEST(Residual, FactSheet_IsTheListedToFourDigits) {
  for (const Listed& row : listed) {
    SCOPED_TRACE(testing::Message()
                 << std::hex << row.polynomial << std::dec << " " << row.data_bits);
    const auto undetected =
        undetected_of(weights_of({row.polynomial, row.crc_bits, row.data_bits}));
    // Half a unit of the fourth digit is at most 5.01e-4 of the number.
    const auto near = [](long double value, long double listed_value) {
      return std::abs(value - listed_value) <= 5.01e-4L * listed_value;
    };
    EXPECT_TRUE(near(probability(undetected, 1e-2L), row.at_1e2));
    EXPECT_TRUE(near(probability(undetected, 1e-3L), row.at_1e3));
    EXPECT_TRUE(near(probability(undetected, 1e-4L), row.at_1e4));
    const WorstRate worst = worst_rate(undetected);
    EXPECT_NEAR(static_cast<double>(worst.probability / row.highest), 1.0, 5e-5);
    EXPECT_GE(worst.bound, worst.probability);
    EXPECT_LE(worst.bound, worst.probability * (1 + 1.1e-6L));
  }
}

TEST(Residual, RateZeroAndOne_TakeOnlyTheEnds) {
  const Undetected undetected{0, 0, 3, 1};
  EXPECT_EQ(probability(undetected, 0), 0);
  EXPECT_EQ(probability(undetected, 1), 1);
  EXPECT_NEAR(static_cast<double>(probability(undetected, 0.5L)), 4.0 / 8, 1e-15);
}

TEST(WorstRate, OneWeight_IsItsShareOfTheBits) {
  Undetected undetected(21, 0);
  undetected[3] = 17;
  const WorstRate worst = worst_rate(undetected);
  EXPECT_NEAR(static_cast<double>(worst.bit_error_rate), 0.15, 1e-6);
  EXPECT_NEAR(static_cast<double>(worst.probability), 17 * std::pow(.15, 3) * std::pow(.85, 17),
              1e-9);
}

// Weight 2 makes a peak near 0.02, weight 60 one beyond 1/2 that is already higher at 1/2.
TEST(WorstRate, TwoPeaks_TheHigherOneIsFound) {
  for (const long double second : {1e20L, 1e30L}) {
    Undetected undetected(101, 0);
    undetected[2] = 1;
    undetected[60] = second;
    long double highest = 0;
    for (int i = 0; i <= 5000; ++i) {
      highest = std::max(highest, probability(undetected, static_cast<long double>(i) / 10000));
    }
    const WorstRate worst = worst_rate(undetected);
    EXPECT_GE(worst.probability, highest * (1 - 1e-9L));
    EXPECT_LE(worst.probability, highest * (1 + 1e-4L));
    EXPECT_EQ(worst.bit_error_rate > 0.4L, second == 1e30L);
  }
}

TEST(WorstRate, NothingUndetected_IsZero) {
  EXPECT_EQ(worst_rate(Undetected(9, 0)).probability, 0);
}

TEST(RateReaching, ProbabilityThere_IsTheLimit) {
  const auto undetected = undetected_of(weights_of({0x190D9, 16, 36}));
  for (const long double limit : {1e-30L, 1e-17L, 1e-9L, 1.4e-5L}) {
    const auto rate = rate_reaching(undetected, limit);
    ASSERT_TRUE(rate);
    EXPECT_NEAR(static_cast<double>(probability(undetected, *rate) / limit), 1.0, 1e-9);
    EXPECT_LT(probability(undetected, *rate * 0.999L), limit);
  }
  EXPECT_EQ(rate_reaching(undetected, 1.6e-5L), std::nullopt);
}

TEST(Statistics, Deviation_IsThatOfTheSameProbability) {
  // P(0 | 3) = exp(-3) = 0.049787; P(>= 10 | 3) = 0.00110249; P(>= 1 | 1e-6) = 1e-6.
  EXPECT_NEAR(deviation_of(0, 3, 3), -1.64692, 1e-4);
  EXPECT_NEAR(deviation_of(10, 3, 3), 3.06114, 1e-4);
  EXPECT_NEAR(deviation_of(1, 1e-6L, 1e-6L), 4.75342, 1e-4);
  EXPECT_GT(deviation_of(1, 1e-17L, 1e-17L), 8);
  EXPECT_NEAR(deviation_of(0, 1e-9L, 1e-9L), 0, 1e-6);
  EXPECT_NEAR(deviation_of(15'500, 15'873, 15'621), -2.984, 1e-3);
}

}  // namespace residual_test
}  // namespace biss::lab
