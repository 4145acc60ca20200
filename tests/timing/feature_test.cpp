// Each file in features/ run with the slave of the core and with the slave of the oracle.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/timing/feature.hpp"

namespace timing_test::feature_test {

std::vector<Feature> features() { return read_features(BISS_TIMING_FEATURES); }

void expect_written(const Feature& feature, const Answers& answers, const char* who) {
  ASSERT_EQ(answers.size(), feature.slo.size());
  for (const auto& [k, slo] : feature.slo) {
    EXPECT_EQ(text_of(answers[k].slo), text_of(slo)) << feature.file << ", slave " << k << who;
  }
  for (const auto& [k, samples] : feature.samples) {
    EXPECT_EQ(answers[k].samples, samples) << feature.file << ", slave " << k << who;
  }
  for (const auto& [k, cdm] : feature.cdm) {
    EXPECT_EQ(answers[k].cdm, cdm) << feature.file << ", slave " << k << who;
  }
}

TEST(TimingFeatures, Slave_AnswersAsWritten) {
  ASSERT_GE(features().size(), 16U);
  for (const Feature& feature : features()) {
    expect_written(feature, answers_of_core(feature.scenario), " of the core");
  }
}

TEST(TimingFeatures, Oracle_AnswersAsWritten) {
  for (const Feature& feature : features()) {
    expect_written(feature, answers_of_oracle(feature.scenario), " of the oracle");
  }
}

TEST(TimingFeatures, ClockStoppedAtAnyEdge_EndsIdleForBoth) {
  for (const Feature& feature : features()) {
    Scenario scenario = feature.scenario;
    while (!scenario.ma.empty()) {
      scenario.ma.pop_back();
      const Answers answers = answers_of_core(scenario);
      ASSERT_EQ(difference(answers, answers_of_oracle(scenario)), "")
          << feature.file << " up to edge " << scenario.ma.size();
      for (const oracle::SlaveAnswer& answer : answers) {
        EXPECT_TRUE(answer.slo.empty() || answer.slo.back().level) << feature.file;
      }
    }
  }
}

TEST(TimingFeatures, Document_IsDrawnFromTheFiles) {
  std::ifstream file(BISS_TIMING_DOCUMENT);
  const std::string written{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(written == document_of(features())) << "write docs/timing.md again: "
                                                     "biss_timing_document tests/timing/features";
}

}  // namespace timing_test::feature_test
