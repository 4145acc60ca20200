// The format of a line that nothing is known of.
#include <gtest/gtest.h>

#include <algorithm>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"
#include "sim/random.hpp"
#include "tests/common/long_run.hpp"
#include "tests/identify/format_trial.hpp"

namespace biss::trial::format_trial_test {

std::string text_of(const identify::FormatFinding& finding) {
  if (finding.candidates.empty()) return "nothing";
  return std::string(format_text(finding.candidates.front().format).view());
}

// nE and nW, as most encoders have them. Bits that are always 0 in their place may be padding, flags
// that are active-high, or flags that are always active.
bool has_usual_flags(const FrameFormat& format) {
  return std::all_of(format.channels().begin(), format.channels().end(), [](const auto& channel) {
    return channel.error.present && !channel.error.active_high && channel.warning.present &&
           !channel.warning.active_high;
  });
}

TEST(FindFormat, CatalogueFormatsInMotion_AreFoundForSure) {
  using enum sim::MotionKind;
  std::uint64_t number = 0;
  for (const CatalogueEntry& entry : catalogue) {
    for (const sim::MotionKind motion : {ramp, sine, random, max}) {
      const TrialResult result = run(trial_of(entry.frame_format(), motion, 200, ++number));
      SCOPED_TRACE(testing::Message() << entry.name << ", motion " << static_cast<int>(motion)
                                      << ": " << text_of(result.finding));
      EXPECT_EQ(result.mistake, "");
      // At constant speed the lowest bits may stand still: the scale is then not known.
      const bool shows_scale = motion != max;
      EXPECT_TRUE(result.sure || !shows_scale || !has_usual_flags(entry.frame_format()));
    }
  }
}

TEST(FindFormat, RandomFormats_AreFoundAndRarelyWronglySure) {
  std::uint64_t judged = 0;
  std::uint64_t found = 0;
  std::uint64_t wrong = 0;
  for (std::uint64_t number = 1; number <= 150; ++number) {
    const FormatTrial trial = random_trial(number);
    const TrialResult result = run(trial);
    wrong += result.sure && !result.mistake.empty() ? 1U : 0U;
    if (trial.cycles < 100 || result.moved < 8) continue;
    ++judged;
    found += result.mistake.empty() ? 1U : 0U;
  }
  EXPECT_GE(100 * found, 90 * judged) << found << " of " << judged;
  // A counter that goes on evenly next to a position that does, too.
  EXPECT_LE(wrong, 3U);
}

TEST(FindFormat, PositionAtRest_IsNotKnown) {
  const TrialResult result =
      run(trial_of(parse_format("pos26,nE,nW,crc6").value(), sim::MotionKind::constant, 200, 1));
  EXPECT_TRUE(result.finding.still);
  EXPECT_EQ(result.finding.sure(), nullptr);
  EXPECT_FALSE(result.finding.candidates.empty());
}

// Bits without a checksum, of any length: noise, a word at rest, single flips, a counter.
std::vector<identify::Sample> bits_without_checksum(std::uint64_t number) {
  sim::Random random(number);
  const auto length = static_cast<unsigned>(1 + random.below(max_payload_bits));
  const std::uint64_t kind = random.below(4);
  const std::uint64_t rest = random.next();
  std::vector<identify::Sample> samples(random.below(250));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].cycle = i;
    samples[i].time = microseconds(static_cast<std::int64_t>(i) * 50);
    for (unsigned at = 0; at < length; at += 64) {
      const unsigned count = std::min(64U, length - at);
      std::uint64_t word = rest + at;
      if (kind == 0) word = random.next();
      if (kind == 1 && random.below(2) == 0) word ^= std::uint64_t{1} << random.below(64);
      if (kind == 2 && at == 0) word += i << (64U - count);
      samples[i].bits.append(word >> (64U - count), count);
    }
  }
  return samples;
}

TEST(FindFormat, BitsWithoutChecksum_AreNeverSureAndEveryCandidateIsTheFormatOfItsText) {
  const std::uint64_t captures = test::rounds(30, 10);
  std::size_t candidates = 0;
  for (std::uint64_t number = 1; number <= captures; ++number) {
    const identify::FormatFinding finding = identify::find_format(bits_without_checksum(number));
    EXPECT_EQ(finding.sure(), nullptr) << number;
    for (const auto& each : finding.candidates) {
      const FormatText text = format_text(each.format);
      EXPECT_TRUE(parse_format(text.view()).value() == each.format) << text.view();
      ++candidates;
    }
  }
  EXPECT_GT(candidates, captures);
}

TEST(FindFormat, NoFrame_FindsNothing) {
  EXPECT_TRUE(identify::find_format({}).candidates.empty());
}

}  // namespace biss::trial::format_trial_test
