#include "lab/sequence_encoder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <set>

#include "biss/safety/configurations.hpp"

namespace biss::lab {
namespace {

constexpr std::uint64_t seed = 20'261'121;

SequenceFrame frame_of(const SafetyConfiguration& type,
                       CounterMode counter = CounterMode::count_1_63) {
  return SequenceFrame::make(type.frame_format(), type.setup, counter, counter).value();
}
SequenceFrame frame_of(const char* name) { return frame_of(*find_safety_configuration(name)); }

// CPW less SPW as the monitor sees it.
std::int32_t difference_of(const SequenceFrame& frame, const SequenceWords& words) {
  sim::Random random(seed);
  const FrameBits bits = frame.encode(words, random);
  const SafetyFinding found =
      FieldEvaluation<SequenceFrame::Plan>::find(frame.ready().plan(), bits.view());
  EXPECT_EQ(found.life_counter, words.life_counter);
  EXPECT_EQ(found.position, words.cpw);
  return found.difference_lsb;
}

TEST(SequenceEncoder, TruncatedWords_AreTheSamePlace) {
  for (const SafetyConfiguration& type : safety_configurations) {
    const SequenceFrame frame = frame_of(type);
    SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::steps,
                            WordRule::truncated, seed);
    for (int n = 0; n < 1000; ++n) ASSERT_EQ(difference_of(frame, encoder.next()), 0) << type.name;
  }
}

TEST(SequenceEncoder, RoundedWords_AreOffByUpToTheTolerance) {
  for (const SafetyConfiguration& type : safety_configurations) {
    const SequenceFrame frame = frame_of(type);
    SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::creep,
                            WordRule::rounded, seed);
    std::set<std::int32_t> seen;
    for (int n = 0; n < 2000; ++n) seen.insert(difference_of(frame, encoder.next()));
    EXPECT_EQ(seen, (std::set<std::int32_t>{-1, 0, 1})) << type.name;
  }
}

TEST(SequenceEncoder, FullSpeed_IsJustLessThanHalfATurnBothWays) {
  for (const char* name : {"fs-36-28", "rsm"}) {
    const SequenceFrame frame = frame_of(name);
    const ChannelFormat& cpw = frame.words().cpw_format();
    const unsigned turn = cpw.position.present() ? cpw.position.bits : cpw.singleturn.bits;
    SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::max,
                            WordRule::truncated, seed);
    std::uint64_t before = encoder.next().cpw;
    unsigned forwards = 0;
    unsigned backwards = 0;
    for (int n = 1; n < 512; ++n) {
      const std::uint64_t now = encoder.next().cpw;
      const std::uint64_t ahead = (now - before) & low_mask(cpw.position_bits());
      const std::uint64_t behind = (before - now) & low_mask(cpw.position_bits());
      const std::uint64_t step = std::min(ahead, behind);
      EXPECT_LT(step, std::uint64_t{1} << (turn - 1U));
      EXPECT_GT(step, std::uint64_t{7} << (turn - 4U));
      ++(ahead < behind ? forwards : backwards);
      before = now;
    }
    EXPECT_EQ(std::min(forwards, backwards), 255U) << name;
    EXPECT_EQ(std::max(forwards, backwards), 256U) << name;
  }
}

TEST(SequenceEncoder, EverySpeed_FromACountToHalfTheRange) {
  const SequenceFrame frame = frame_of("fs-28-24");
  SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::steps,
                          WordRule::truncated, seed);
  std::set<std::size_t> magnitudes;
  for (int n = 0; n < 1000 * 512; ++n) {
    const std::uint64_t before = encoder.next().cpw;
    if (n % 512 != 0) continue;
    const std::uint64_t ahead = (encoder.next().cpw - before) & low_mask(28);
    magnitudes.insert(std::bit_width(std::min(ahead, (std::uint64_t{1} << 28U) - ahead)));
    ++n;
  }
  for (std::size_t magnitude = 1; magnitude <= 27; ++magnitude) {
    EXPECT_TRUE(magnitudes.count(magnitude)) << magnitude;
  }
}

// A carry of k bits turns over k + 1.
TEST(SequenceEncoder, Creep_HasCarriesOfEveryLength) {
  const SequenceFrame frame = frame_of("fs-36-28");
  SequenceEncoder encoder(frame, CounterMode::count_1_63, SequenceMotion::creep,
                          WordRule::truncated, seed);
  std::set<std::size_t> carries;
  std::uint64_t before = encoder.next().cpw;
  for (int n = 1; n < 512 * 500; ++n) {
    const std::uint64_t now = encoder.next().cpw;
    if (n % 512 != 0) carries.insert(static_cast<std::size_t>(std::bit_width(before ^ now)));
    before = now;
  }
  EXPECT_EQ(carries.size(), 37U);
}

TEST(SequenceEncoder, EveryMotion_WrapsPositionAndCounter) {
  for (const SafetyConfiguration& type : safety_configurations) {
    const SequenceFrame frame = frame_of(type, CounterMode::count_0_63);
    for (const auto motion : {SequenceMotion::max, SequenceMotion::steps, SequenceMotion::creep}) {
      SequenceEncoder encoder(frame, CounterMode::count_0_63, motion, WordRule::rounded, seed);
      for (int n = 0; n < 6400; ++n) encoder.next();
      EXPECT_GE(encoder.position_wraps(), 3U) << type.name;
      EXPECT_GE(encoder.counter_wraps(), 99U);
      EXPECT_LE(encoder.counter_wraps(), 100U);
    }
  }
}

TEST(SequenceFrame, OtherStarts_AreNeverOurChecksums) {
  const SequenceFrame frame = frame_of("fs-36-28");
  sim::Random random(seed);
  for (const SequenceFrame::Codec& other : frame.other_starts()) {
    for (int n = 0; n < 1000; ++n) {
      const std::uint64_t cpw = random.next() & low_mask(38);
      const std::uint64_t spw = random.next() & low_mask(36);
      EXPECT_TRUE(other.crc(0, cpw) != frame.codec().crc(0, cpw) ||
                  other.crc(1, spw) != frame.codec().crc(1, spw));
    }
  }
}

TEST(SequenceFrame, WordsThatCannotBeMonitored_AreRefused) {
  const auto counter = CounterMode::count_1_63;
  for (const char* text : {"pos26,nE,nW,crc6", "pos26,nE,nW,crc6+pos26,nE,nW,crc16"}) {
    EXPECT_FALSE(SequenceFrame::make(*parse_format(text), {}, counter, counter)) << text;
  }
}

}  // namespace
}  // namespace biss::lab
