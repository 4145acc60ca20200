#include "lab/sequence_theory.hpp"

#include <gtest/gtest.h>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "lab/campaign_theory.hpp"

namespace biss::lab {
namespace {

constexpr std::string_view small_text = "pos6,nE,nW,crc3+pos5,nE,nW,lc6,crc4";

SequenceFrame frame_of(std::string_view text, CounterMode counter = CounterMode::count_1_63) {
  SafetySetup setup;
  setup.comparison.compare_bits = text == small_text ? 4 : 0;
  return SequenceFrame::make(*parse_format(text), setup, counter, counter).value();
}

SequenceRow row_of(TransmissionError kind, std::string_view variant,
                   CounterMode counter = CounterMode::count_1_63) {
  SequenceRow row{
      .task = SequenceTask::fault, .kind = kind, .counter = counter, .encoder_counter = counter};
  while (row.variant_name() != variant) ++row.variant;
  return row;
}

// What a monitor says behind good frames that end with this one.
SafetyVerdict next_of(const SequenceFrame& frame, const SequenceWords& sent,
                      const FrameBits& bits) {
  return frame.words()
      .monitor({sent.cpw, sent.life_counter},
               {bits.view().word(frame.payload_at(bits), frame.words().cpw_bits()),
                bits.view().word(frame.payload_at(bits) + frame.words().cpw_bits(),
                                 frame.words().spw_bits()),
                false})
      .verdict;
}

TEST(SequenceTheory, NoiseInTheSafetyWord_IsWhatAllWordsOfASmallFrameGive) {
  const SequenceFrame frame = frame_of(small_text);
  const unsigned spw_bits = frame.words().spw_bits();
  sim::Random random(1);
  const SequenceWords sent{.cpw = 41, .spw = 20, .life_counter = 63};
  const FrameBits right = frame.encode(sent, random);
  std::uint64_t accepted = 0;
  for (std::uint64_t wrong = 1; wrong < std::uint64_t{1} << spw_bits; ++wrong) {
    FrameBits bits = right;
    for (unsigned bit = 0; bit < spw_bits; ++bit) {
      if (((wrong >> bit) & 1U) != 0) bits.flip(bits.size_bits() - 2U - bit);
    }
    if (next_of(frame, sent, bits) == SafetyVerdict::safe) ++accepted;
  }
  ASSERT_GT(accepted, 0U);
  const auto theory = sequence_theory(frame, row_of(TransmissionError::masquerade, "noise_word"));
  EXPECT_DOUBLE_EQ(static_cast<double>(*theory) * static_cast<double>(1U << spw_bits),
                   static_cast<double>(accepted));
}

TEST(SequenceTheory, AnotherPolynomial_IsWhatAllPositionsAndCountersGive) {
  for (const CounterMode counter : {CounterMode::count_1_63, CounterMode::count_0_63}) {
    const SequenceFrame frame = frame_of(small_text, counter);
    sim::Random random(1);
    std::uint64_t accepted = 0;
    std::uint64_t all = 0;
    for (const SequenceFrame::Codec& other : frame.other_polynomials()) {
      for (std::uint64_t position = 0; position < 64; ++position) {
        for (unsigned value = frame.words().first_counter(); value < 64; ++value) {
          const SequenceWords sent{.cpw = position,
                                   .spw = position >> 1U,
                                   .life_counter = static_cast<std::uint8_t>(value)};
          const FrameBits bits = frame.encode(sent, other, random);
          if (next_of(frame, sent, bits) == SafetyVerdict::safe) ++accepted;
          ++all;
        }
      }
    }
    ASSERT_GT(accepted, 0U);
    const auto theory =
        sequence_theory(frame, row_of(TransmissionError::masquerade, "polynomial", counter));
    EXPECT_DOUBLE_EQ(static_cast<double>(*theory),
                     static_cast<double>(accepted) / static_cast<double>(all));
  }
}

TEST(SequenceTheory, NoiseInBothWords_IsTheCampaignsHalfOfAllBits) {
  for (const std::string_view text :
       {small_text, std::string_view("pos12,nE,nW,crc5+pos10,nE,nW,lc6,crc6")}) {
    const SequenceFrame frame = frame_of(text);
    const auto campaign = campaign_theory(frame.words(), *parse_fault("flips:0.5"));
    ASSERT_TRUE(campaign);
    const auto theory = sequence_theory(frame, row_of(TransmissionError::masquerade, "noise"));
    EXPECT_NEAR(static_cast<double>(*theory / (*campaign)[3]), 1, 1e-9);
  }
}

TEST(SequenceTheory, WhatTheCounterSees_IsNeverAccepted) {
  const SequenceFrame frame = frame_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16");
  for (const auto& [kind, variant] : {std::pair{TransmissionError::repetition, "older"},
                                      std::pair{TransmissionError::insertion, "stale"},
                                      std::pair{TransmissionError::sequence, "shuffled"},
                                      std::pair{TransmissionError::loss, "passed_over"},
                                      std::pair{TransmissionError::delay, "watched"},
                                      std::pair{TransmissionError::masquerade, "standard"},
                                      std::pair{TransmissionError::addressing, "start_value"}}) {
    EXPECT_EQ(sequence_theory(frame, row_of(kind, variant)), 0.0L) << variant;
  }
}

TEST(SequenceTheory, AnotherSource_FitsOnceInAPeriod) {
  const SequenceFrame frame = frame_of(small_text);
  for (const auto& [kind, variant] : {std::pair{TransmissionError::repetition, "any_age"},
                                      std::pair{TransmissionError::insertion, "foreign"},
                                      std::pair{TransmissionError::addressing, "one_frame"}}) {
    EXPECT_EQ(sequence_theory(frame, row_of(kind, variant)), 1.0L / 63);
    EXPECT_EQ(sequence_theory(frame, row_of(kind, variant, CounterMode::count_0_63)), 1.0L / 64);
  }
}

// A word of zeros is a good one there.
TEST(SequenceTheory, ZerosThatMayBeAWord_HaveNone) {
  const SequenceFrame frame = frame_of("pos12,E,crc6:plain+pos12,E,lc6,crc16:plain");
  EXPECT_FALSE(sequence_theory(frame, row_of(TransmissionError::masquerade, "standard")));
}

TEST(SequenceTheory, Deviation_IsThatOfTheSameProbability) {
  // P(0 | 3) = exp(-3) = 0.049787; P(>= 10 | 3) = 0.00110249; P(>= 1 | 1e-6) = 1e-6.
  EXPECT_NEAR(deviation_of(0, 3, 3), -1.64692, 1e-4);
  EXPECT_NEAR(deviation_of(10, 3, 3), 3.06114, 1e-4);
  EXPECT_NEAR(deviation_of(1, 1e-6L, 1e-6L), 4.75342, 1e-4);
  EXPECT_GT(deviation_of(1, 1e-17L, 1e-17L), 8);
  EXPECT_NEAR(deviation_of(0, 1e-9L, 1e-9L), 0, 1e-6);
  EXPECT_NEAR(deviation_of(15'500, 15'873, 15'621), -2.984, 1e-3);
}

}  // namespace
}  // namespace biss::lab
