// The format of a line that nothing is known of.
#include <gtest/gtest.h>

#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/identify/format_trial.hpp"

namespace biss::trial {
namespace format_trial_test {

std::string text_of(const identify::FormatFinding& finding) {
  if (finding.candidates.empty()) return "nothing";
  return std::string(format_text(finding.candidates.front().format).view());
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
      EXPECT_TRUE(result.sure);
    }
  }
}

TEST(FindFormat, RandomFormats_AreFoundAndNeverWronglySure) {
  std::uint64_t judged = 0;
  std::uint64_t found = 0;
  for (std::uint64_t number = 1; number <= 150; ++number) {
    const FormatTrial trial = random_trial(number);
    const TrialResult result = run(trial);
    SCOPED_TRACE(testing::Message() << "trial " << number << ": " << trial.text << " read as "
                                    << text_of(result.finding) << ": " << result.mistake);
    EXPECT_FALSE(result.sure && !result.mistake.empty());
    if (trial.cycles < 100 || result.moved < 8) continue;
    ++judged;
    found += result.mistake.empty() ? 1U : 0U;
  }
  EXPECT_GE(100 * found, 95 * judged) << found << " of " << judged;
}

TEST(FindFormat, PositionAtRest_IsNotKnown) {
  const TrialResult result =
      run(trial_of(parse_format("pos26,nE,nW,crc6").value(), sim::MotionKind::constant, 200, 1));
  EXPECT_TRUE(result.finding.still);
  EXPECT_EQ(result.finding.sure(), nullptr);
  EXPECT_FALSE(result.finding.candidates.empty());
}

TEST(FindFormat, NoFrame_FindsNothing) {
  EXPECT_TRUE(identify::find_format({}).candidates.empty());
}

}  // namespace format_trial_test
}  // namespace biss::trial
