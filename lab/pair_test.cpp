#include "lab/pair.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <bit>
#include <cmath>
#include <string_view>
#include <vector>

#include "biss/crc/engines.hpp"
#include "biss/frame/format_text.hpp"
#include "lab/weights.hpp"

namespace biss::lab {
namespace pair_test {

FrameFormat format_of(std::string_view text) {
  const auto format = parse_format(text);
  EXPECT_TRUE(format.ok()) << text;
  return *format;
}

// Every position, every error pattern over both words, every check as in a receiver.
class Counted {
 public:
  Counted(const FrameFormat& format, const SafetyComparison& comparison, unsigned compare_bits)
      : format_(format), comparison_(comparison), compare_bits_(compare_bits) {
    const auto& control = format.channel_list[0];
    const auto& safety = format.channel_list[1];
    const auto first_errors = accepted(control);
    const auto second_errors = accepted(safety);
    out.wrong.assign(control.total_bits() + safety.total_bits() + 1, 0);
    out.beyond_tolerance = out.wrong;
    const unsigned position_bits = control.position_bits();
    const auto share = 1 / static_cast<long double>(std::uint64_t{1} << position_bits);
    for (std::uint64_t position = 0; position < std::uint64_t{1} << position_bits; ++position) {
      for (const Error& first : first_errors) {
        for (const Error& second : second_errors) judge(position, first, second, share);
      }
    }
  }

  PairWeights out;

 private:
  struct Error {
    std::uint64_t data;
    unsigned wrong_bits;
  };

  // Error patterns that the checksum does not detect, found by search.
  static std::vector<Error> accepted(const ChannelFormat& channel) {
    std::vector<Error> errors;
    const CrcBitwise crc(channel.crc);
    const unsigned width = channel.crc.width_bits;
    for (std::uint64_t error = 0; error < std::uint64_t{1} << channel.total_bits(); ++error) {
      const std::uint64_t data = error >> width;
      const std::uint64_t word = crc(0x5A & low_mask(channel.data_bits), channel.data_bits);
      const std::uint64_t seen = (0x5A & low_mask(channel.data_bits)) ^ data;
      if (crc(seen, channel.data_bits) != (word ^ (error & low_mask(width)))) continue;
      errors.push_back({data, static_cast<unsigned>(std::popcount(error))});
    }
    return errors;
  }

  static Field fine(const ChannelFormat& channel) {
    return channel.position.present() ? channel.position : channel.singleturn;
  }

  // Turns and the compared top of the singleturn as one number.
  std::uint64_t compared(std::uint64_t turns, std::uint64_t singleturn, unsigned bits) const {
    return (turns << compare_bits_) | (singleturn >> (bits - compare_bits_));
  }

  bool near(std::uint64_t a, std::uint64_t b, std::uint64_t range) const {
    const std::uint64_t up = (a + range - b) % range;
    return up <= comparison_.tolerance_lsb || range - up <= comparison_.tolerance_lsb;
  }

  void judge(std::uint64_t position, const Error& first, const Error& second, long double share) {
    const auto& control = format_.channel_list[0];
    const auto& safety = format_.channel_list[1];
    if (safety.life_counter.of(second.data) != 0) return;
    if (((first.data >> control.error.shift) & 1U) != 0) return;
    if (safety.error.present && ((second.data >> safety.error.shift) & 1U) != 0) return;
    const Field a = fine(control);
    const Field b = fine(safety);
    const std::uint64_t singleturn = position & low_mask(a.bits);
    const std::uint64_t turns = position >> a.bits;
    const std::uint64_t read_turns = turns ^ control.multiturn.of(first.data);
    const std::uint64_t read_singleturn = singleturn ^ a.of(first.data);
    // The safety word has the top of the singleturn and the last bits of the turns.
    const unsigned turn_bits = std::min(control.multiturn.bits, safety.multiturn.bits);
    const std::uint64_t second_singleturn = (singleturn >> (a.bits - b.bits)) ^ b.of(second.data);
    const std::uint64_t second_turns =
        (turns ^ safety.multiturn.of(second.data)) & low_mask(turn_bits);
    const std::uint64_t range = std::uint64_t{1} << (turn_bits + compare_bits_);
    const std::uint64_t value = compared(read_turns & low_mask(turn_bits), read_singleturn, a.bits);
    if (!near(value, compared(second_turns, second_singleturn, b.bits), range)) return;
    const unsigned wrong_bits = first.wrong_bits + second.wrong_bits;
    if (read_turns != turns || read_singleturn != singleturn) out.wrong[wrong_bits] += share;
    if (!near(value, compared(turns & low_mask(turn_bits), singleturn, a.bits), range)) {
      out.beyond_tolerance[wrong_bits] += share;
    }
  }

  const FrameFormat& format_;
  const SafetyComparison& comparison_;
  unsigned compare_bits_;
};

void expect_counted(std::string_view text, const SafetyComparison& comparison,
                    unsigned compare_bits) {
  SCOPED_TRACE(text);
  const FrameFormat format = format_of(text);
  ASSERT_EQ(pair_problem(format, comparison), std::nullopt);
  const PairWeights found = pair_weights(format, comparison);
  const Counted counted(format, comparison, compare_bits);
  long double sum = 0;
  ASSERT_EQ(found.wrong.size(), counted.out.wrong.size());
  for (std::size_t w = 0; w < found.wrong.size(); ++w) {
    EXPECT_EQ(found.wrong[w], counted.out.wrong[w]) << w;
    EXPECT_EQ(found.beyond_tolerance[w], counted.out.beyond_tolerance[w]) << w;
    sum += found.beyond_tolerance[w];
  }
  EXPECT_GT(sum, 0);  // or nothing was compared here
}

TEST(Pair, SmallWords_AreWhatCountingFinds) {
  expect_counted("pos4,nE,crc3+pos4,nE,lc2,crc4", {}, 4);
  expect_counted("pos5,nE,nW,crc3+pos4,nE,lc2,crc4", {}, 4);
  expect_counted("pos6,nE,crc3:0xD+pos4,nE,lc1,crc3", {}, 4);
  expect_counted("nE,pos6,crc4+lc2,pos4,crc3", {}, 4);
}

TEST(Pair, FewComparedBits_AreWhatCountingFinds) {
  expect_counted("pos6,nE,crc3+pos5,nE,lc2,crc4", {.compare_bits = 3}, 3);
  expect_counted("pos6,nE,crc3+pos5,nE,lc2,crc4", {.compare_bits = 2}, 2);
}

TEST(Pair, OtherChecks_AreWhatCountingFinds) {
  expect_counted("pos5,nE,crc3+pos4,nE,lc2,crc4", {.tolerance_lsb = 0}, 4);
}

TEST(Pair, Turns_AreComparedAboveTheSingleturn) {
  expect_counted("mt2,st4,nE,crc3+mt2,st3,nE,lc1,crc3", {}, 3);
  expect_counted("mt2,st4,nE,crc3+mt2,st3,nE,lc1,crc3", {.compare_bits = 2}, 2);
  // A safety word without turns, and one with fewer.
  expect_counted("mt2,st4,nE,crc3+st3,nE,lc1,crc3", {}, 3);
  expect_counted("mt3,st3,nE,crc3+mt2,st3,nE,lc1,crc3", {}, 3);
}

TEST(Pair, CoarseAgreement_NeedsErrorsInBothWords) {
  const auto found = pair_weights(format_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"));
  EXPECT_EQ(found.bits, 96U);
  EXPECT_EQ(found.compared_bits, 28U);
  // Three wrong bits of the control word whose effect on the compared bits passes.
  EXPECT_EQ(found.wrong[3], 12);
  // Beyond the tolerance not below three in one and six in the other.
  for (unsigned w = 0; w < 9; ++w) EXPECT_EQ(found.beyond_tolerance[w], 0) << w;
  EXPECT_GT(found.beyond_tolerance[9], 0);
  for (unsigned w = 0; w <= 96; ++w) EXPECT_LE(found.beyond_tolerance[w], found.wrong[w]) << w;
}

// At a rate of 1/2 every pattern is equally likely: 2^-22 pass the checksums, 2^-8 counter and
// flags, 3 of 2^28 differences the comparison.
TEST(Pair, RateOfOneHalf_IsTheShareOfAllPatterns) {
  const auto found = pair_weights(format_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"));
  const long double share = std::ldexp(3.0L, -22 - 8 - 28);
  EXPECT_NEAR(static_cast<double>(probability(found.wrong, 0.5L) / share), 1.0, 1e-7);
  EXPECT_NEAR(static_cast<double>(probability(found.beyond_tolerance, 0.5L) / share), 1.0, 1e-7);
}

TEST(Pair, WidestWords_StayExact) {
  const auto found = pair_weights(format_of("pos64,crc6+pos64,crc16"), {.compare_bits = 9});
  long double sum = 0;
  for (const long double number : found.wrong) sum += number;
  // All pairs of code words times 3 of 2^9.
  EXPECT_NEAR(static_cast<double>(sum / std::ldexp(3.0L, 128 - 9)), 1.0, 1e-12);
}

TEST(Pair, WhatCannotBeCounted_IsNamed) {
  EXPECT_EQ(pair_problem(format_of("pos26,nE,nW,crc6")), PairError::no_pair);
  EXPECT_EQ(pair_problem(format_of("pos26,crc6+nE,lc6,crc16")), PairError::no_pair);
  EXPECT_EQ(pair_problem(format_of("st26:gray,crc6+pos26,crc16")), PairError::nothing_to_compare);
  EXPECT_EQ(pair_problem(format_of("pos26,crc6+pos26,crc16"), {.tolerance_lsb = 2}),
            PairError::tolerance);
  EXPECT_EQ(pair_problem(format_of("pos26,crc16+pos26,crc16")), PairError::too_many_checks);
}

TEST(Comparison, PassingMasks_AreWhatCountingFinds) {
  for (const unsigned tolerance : {0U, 1U, 3U}) {
    constexpr unsigned bits = 5;
    const auto masks = passing_masks(bits, tolerance);
    for (std::uint64_t mask = 0; mask < 32; ++mask) {
      int passing = 0;
      for (std::uint64_t value = 0; value < 32; ++value) {
        const std::uint64_t up = ((value ^ mask) - value) % 32;
        passing += up <= tolerance || 32 - up <= tolerance ? 1 : 0;
      }
      const auto found = masks.find(mask);
      EXPECT_EQ(found == masks.end() ? 0 : found->second, passing / 32.0L) << mask;
    }
  }
}

}  // namespace pair_test
}  // namespace biss::lab
