#include "lab/weights.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "biss/crc/engines.hpp"
#include "lab/distance.hpp"

namespace biss::lab {
namespace weights_test {

struct Listed {
  std::uint32_t polynomial;
  unsigned crc_bits;
  unsigned data_bits;
  unsigned distance;
  unsigned step;  // from one listed weight to the next
  std::vector<std::uint64_t> numbers;
};

// The fact sheet's section 9 and the tables of error-detection.
const std::vector<Listed> listed = {
    {0x43, 6, 14, 3, 1, {22, 81, 230, 589}},
    {0x43, 6, 20, 3, 1, {40, 240, 1043, 3614}},
    {0x43, 6, 26, 3, 1, {81, 579, 3141, 14200}},
    {0x43, 6, 28, 3, 1, {98, 753, 4331, 21004}},
    {0x43, 6, 30, 3, 1, {119, 958, 5845, 30392}},
    {0x43, 6, 32, 3, 1, {141, 1203}},
    {0x43, 6, 34, 3, 1, {163, 1495, 10227, 59758}},
    {0x43, 6, 36, 3, 1, {186, 1838}},
    {0x43, 6, 38, 3, 1, {213, 2230, 16962, 109758}},
    {0x43, 6, 40, 3, 1, {244, 2679}},
    {0x43, 6, 42, 3, 1, {279, 3193, 26730, 190882}},
    {0x43, 6, 48, 3, 1, {405, 5186}},
    {0x43, 6, 50, 3, 1, {454, 6021, 59447, 505208}},
    {0x43, 6, 57, 3, 1, {651, 9765, 109368, 1057224}},
    {0x43, 6, 64, 2, 1, {7, 890, 14790}},
    {0x190D9, 16, 20, 6, 2, {48, 885, 8036, 37684}},
    {0x190D9, 16, 24, 6, 2, {108, 2260, 26397, 169619}},
    {0x190D9, 16, 28, 6, 2, {209, 5308}},
    {0x190D9, 16, 30, 6, 2, {283, 7865}},
    {0x190D9, 16, 32, 6, 2, {369, 11432, 200556, 2122740}},
    {0x190D9, 16, 34, 6, 2, {473, 16338}},
    {0x190D9, 16, 36, 6, 2, {602, 23028, 483431, 6293666}},
    {0x190D9, 16, 38, 6, 2, {760, 31917}},
    {0x190D9, 16, 40, 6, 2, {946, 43617, 1087218, 17032485}},
    {0x190D9, 16, 44, 6, 2, {1454, 78687, 2300435, 42697320}},
    {0x190D9, 16, 48, 6, 2, {2191, 136168, 4619531, 100227020}},
    {0x190D9, 16, 57, 6, 2, {5113, 412517}},
    {0x190D9, 16, 64, 6, 2, {9153, 888044}},
    {0x13, 4, 11, 3, 1, {35, 105, 168, 280}},
    {0x13, 4, 8, 3, 1, {17, 38, 44, 52}},
    {0x197, 8, 28, 4, 2, {452, 15334, 236084, 1985986}},
    {0x197, 8, 34, 4, 2, {873, 41146, 921372, 11497168}},
    {0x197, 8, 38, 4, 2, {1281, 73372, 2037347, 31850148}},
};

// Pascal's triangle, in integers.
Count binomial(unsigned n, unsigned k) {
  Count result = 1;
  for (unsigned i = 1; i <= k; ++i) result = result * (n - k + i) / i;
  return result;
}

TEST(Weights, FactSheet_AreTheListed) {
  for (const Listed& row : listed) {
    SCOPED_TRACE(testing::Message()
                 << std::hex << row.polynomial << std::dec << " " << row.data_bits);
    const auto weights = weights_of({row.polynomial, row.crc_bits, row.data_bits});
    EXPECT_EQ(min_distance(weights), row.distance);
    for (unsigned i = 0; i < row.numbers.size(); ++i) {
      EXPECT_EQ(static_cast<std::uint64_t>(weights[row.distance + i * row.step]), row.numbers[i]);
      EXPECT_TRUE(row.step == 1 || weights[row.distance + 2 * i + 1] == 0);
    }
  }
}

TEST(Weights, EveryPolynomialAndWidth_AddUpToAllCodeWords) {
  for (unsigned crc_bits = 1; crc_bits <= 16; ++crc_bits) {
    for (const unsigned data_bits : {1U, 13U, 40U, 64U}) {
      const std::uint32_t top = 1U << crc_bits;
      for (const std::uint32_t polynomial : {top | 1U, top | (top >> 1U) | 1U, 2 * top - 1U}) {
        const auto weights = weights_of({polynomial, crc_bits, data_bits});
        Count sum = 0;
        for (const Count number : weights) sum += number;
        EXPECT_TRUE(sum == Count{1} << data_bits) << polynomial << " " << data_bits;
        EXPECT_TRUE(weights[0] == 1);
      }
    }
  }
}

TEST(Weights, WithoutChecksum_AreTheBinomialCoefficients) {
  const auto weights = weights_of({0, 0, 64});
  for (unsigned w = 0; w <= 64; ++w) EXPECT_TRUE(weights[w] == binomial(64, w)) << w;
}

// Every data word through the core's CRC, which does not use dual codes.
TEST(Weights, SmallWords_AreWhatCountingFinds) {
  for (const CrcSpec& spec :
       {CrcSpec{0x0B, 0, 3, true}, CrcSpec{0x43, 0, 6, true}, CrcSpec{0x12F, 0, 8, false},
        CrcSpec{0x190D9, 0, 16, true}, CrcSpec{0x1021, 0, 12, false}}) {
    for (const unsigned data_bits : {1U, 7U, 14U}) {
      const CrcBitwise crc(spec);
      std::vector<Count> counted(data_bits + spec.width_bits + 1, 0);
      const std::uint16_t of_zero = crc(0, data_bits);
      for (std::uint64_t data = 0; data < std::uint64_t{1} << data_bits; ++data) {
        const unsigned check = static_cast<unsigned>(crc(data, data_bits) ^ of_zero);
        ++counted[static_cast<unsigned>(std::popcount(data) + std::popcount(check))];
      }
      EXPECT_TRUE(weights_of({spec.polynomial, spec.width_bits, data_bits}) == counted)
          << spec.polynomial << " " << data_bits;
    }
  }
}

TEST(Weights, FixedBits_AreWhatCountingFinds) {
  const CrcBitwise crc(crc6);
  const FixedBits fixed{0b1101'0000'0011, 0b0101'0000'0010};
  std::vector<Count> counted(12 + 6 + 1, 0);
  for (std::uint64_t data = 0; data < 4096; ++data) {
    if ((data & fixed.mask) != fixed.value) continue;
    const unsigned check = static_cast<unsigned>(crc(data, 12) ^ crc(0, 12));
    ++counted[static_cast<unsigned>(std::popcount(data) + std::popcount(check))];
  }
  EXPECT_TRUE(weights_of({0x43, 6, 12}, fixed) == counted);
}

using testing::ElementsAre;

TEST(Distance, FactSheet_IsTheListed) {
  EXPECT_THAT(distance_runs(0x13), ElementsAre(DistanceRun{3, 1, 11}, DistanceRun{2, 12, {}}));
  EXPECT_THAT(distance_runs(0x25), ElementsAre(DistanceRun{3, 1, 26}, DistanceRun{2, 27, {}}));
  EXPECT_THAT(distance_runs(0x43), ElementsAre(DistanceRun{3, 1, 57}, DistanceRun{2, 58, {}}));
  EXPECT_THAT(distance_runs(0x89), ElementsAre(DistanceRun{3, 1, 120}, DistanceRun{2, 121, {}}));
  EXPECT_THAT(distance_runs(0x97),
              ElementsAre(DistanceRun{5, 1, 3}, DistanceRun{3, 4, 35}, DistanceRun{2, 36, {}}));
  EXPECT_THAT(distance_runs(0x12F),
              ElementsAre(DistanceRun{6, 1, 3}, DistanceRun{4, 4, 119}, DistanceRun{2, 120, {}}));
  EXPECT_THAT(distance_runs(0x197),
              ElementsAre(DistanceRun{6, 1, 3}, DistanceRun{4, 4, 116}, DistanceRun{2, 117, {}}));
  EXPECT_THAT(distance_runs(0x190D9),
              ElementsAre(DistanceRun{8, 1, 5}, DistanceRun{6, 6, 135}, DistanceRun{2, 136, {}}));
}

TEST(Distance, LongestData_IsTheListed) {
  // The longest data with at least this distance; 0: no length, nothing: every length.
  const auto longest = [](std::uint32_t polynomial, unsigned distance) {
    std::optional<unsigned> most = 0;
    for (const DistanceRun& run : distance_runs(polynomial)) {
      if (run.distance >= distance) most = run.data_bits_max;
    }
    return most;
  };
  EXPECT_EQ(longest(0x43, 3), 57U);
  EXPECT_EQ(longest(0x43, 4), 0U);
  EXPECT_EQ(longest(0x43, 2), std::nullopt);
  EXPECT_EQ(longest(0x190D9, 6), 135U);
  EXPECT_EQ(longest(0x190D9, 7), 5U);
  EXPECT_EQ(longest(0x13D65, 6), 135U);
  EXPECT_EQ(longest(0x197, 5), 3U);
}

TEST(Distance, EveryLengthOfAChannel_IsTheSmallestWeight) {
  for (const auto& [polynomial, crc_bits] :
       std::vector<std::pair<std::uint32_t, unsigned>>{{0x3, 1},
                                                       {0x0B, 3},
                                                       {0xA7, 7},
                                                       {0x97, 7},
                                                       {0x151, 8},
                                                       {0x12F, 8},
                                                       {0x1100B, 16},
                                                       {0x10001, 16},
                                                       {0x1F01, 12},
                                                       {0x190D9, 16}}) {
    const auto runs = distance_runs(polynomial);
    for (unsigned data_bits = 1; data_bits <= 64; ++data_bits) {
      unsigned expected = 0;
      for (const DistanceRun& run : runs) {
        if (data_bits >= run.data_bits_min) expected = run.distance;
      }
      EXPECT_EQ(min_distance(weights_of({polynomial, crc_bits, data_bits})), expected)
          << std::hex << polynomial << std::dec << " " << data_bits;
    }
  }
}

// A burst is a multiple of the polynomial, or it is detected.
bool divides(std::uint32_t polynomial, std::uint32_t pattern) {
  const auto degree = static_cast<int>(std::bit_width(polynomial)) - 1;
  for (auto i = static_cast<int>(std::bit_width(pattern)) - 1; i >= degree; --i) {
    if (((pattern >> i) & 1U) != 0) pattern ^= polynomial << (i - degree);
  }
  return pattern == 0;
}

TEST(Bursts, EveryPattern_AsManyUnseenAsTold) {
  for (const std::uint32_t polynomial : {0x43U, 0x12FU, 0x25U}) {
    const auto crc_bits = static_cast<unsigned>(std::bit_width(polynomial)) - 1U;
    for (unsigned length = 2; length <= 16; ++length) {
      std::uint32_t unseen = 0;
      const std::uint32_t patterns = 1U << (length - 2);
      for (std::uint32_t inside = 0; inside < patterns; ++inside) {
        const std::uint32_t pattern = 1U | (inside << 1U) | (1U << (length - 1));
        unseen += divides(polynomial, pattern) ? 1U : 0U;
      }
      // A checksum detects all bursts up to its length, all but 2^-(crc_bits - 1) of those one bit
      // longer, and all but 2^-crc_bits of longer ones.
      const unsigned longer = length - crc_bits;
      const unsigned passed = length <= crc_bits ? 0U
                              : longer == 1      ? patterns >> (crc_bits - 1)
                                                 : patterns >> crc_bits;
      EXPECT_EQ(unseen, passed) << polynomial << " " << length;
    }
  }
}

}  // namespace weights_test
}  // namespace biss::lab
