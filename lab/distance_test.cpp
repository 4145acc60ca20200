#include "lab/distance.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>

#include <utility>
#include <vector>

#include "lab/weights.hpp"

namespace biss::lab {
namespace {

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
  EXPECT_EQ(data_bits_with(distance_runs(0x43), 3), 57U);
  EXPECT_EQ(data_bits_with(distance_runs(0x43), 4), 0U);
  EXPECT_EQ(data_bits_with(distance_runs(0x43), 2), std::nullopt);
  EXPECT_EQ(data_bits_with(distance_runs(0x190D9), 6), 135U);
  EXPECT_EQ(data_bits_with(distance_runs(0x190D9), 7), 5U);
  EXPECT_EQ(data_bits_with(distance_runs(0x13D65), 6), 135U);
  EXPECT_EQ(data_bits_with(distance_runs(0x197), 5), 3U);
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

// A burst is a multiple of the polynomial or is seen.
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
      const auto halvings = burst_share(crc_bits, length).halvings;
      EXPECT_EQ(unseen, halvings ? patterns >> *halvings : 0U) << polynomial << " " << length;
    }
  }
}

}  // namespace
}  // namespace biss::lab
