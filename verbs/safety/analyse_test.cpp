#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "cli/test_verb_harness.hpp"

namespace biss::verbs {
namespace analyse_test {

using nlohmann::json;
using testing::HasSubstr;

Ran analyse(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"safety", "analyse"});
  return run_verb(arguments);
}

std::vector<json> objects(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--to", "jsonl"});
  const Ran ran = analyse(arguments);
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  std::vector<json> found;
  std::istringstream lines(ran.out);
  for (std::string line; std::getline(lines, line);) found.push_back(json::parse(line));
  return found;
}

TEST(SafetyAnalyse, SafetyFormat_HasAnObjectAChannelAndOneForThePair) {
  const auto found = objects({"-f", "fs-36-28", "--ber", "1e-3"});
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0]["word"], "CPW");
  EXPECT_EQ(found[0]["bits"], 44);
  EXPECT_EQ(found[0]["data_bits"], 38);
  EXPECT_EQ(found[0]["min_distance"], 3);
  EXPECT_EQ(found[0]["weights"].size(), 45U);
  EXPECT_EQ(found[0]["weights"][3], 213);
  EXPECT_EQ(found[0]["ber"], 1e-3);
  EXPECT_NEAR(found[0]["p_undetected"].get<double>(), 2.066e-7, 5e-11);
  EXPECT_NEAR(found[0]["p_undetected_max"].get<double>(), 1.5625e-2, 5e-7);
  EXPECT_EQ(found[0]["distances"][0]["data_bits_max"], 57);
  EXPECT_EQ(found[1]["word"], "SPW");
  EXPECT_EQ(found[1]["min_distance"], 6);
  EXPECT_EQ(found[1]["weights"][6], 602);
  EXPECT_EQ(found[1]["distances"][1]["data_bits_max"], 135);
  EXPECT_EQ(found[2]["word"], "pair");
  EXPECT_EQ(found[2]["bits"], 96);
  EXPECT_EQ(found[2]["min_distance"], 9);
  EXPECT_EQ(found[2]["structure"].size(), 10U);
  EXPECT_LT(found[2]["p_undetected"], found[2]["p_wrong"]);
  for (const json& object : found) {
    EXPECT_THAT(object["model"].get<std::string>(), HasSubstr("not a certificate"));
  }
}

TEST(SafetyAnalyse, SeveralRates_AreListsInTheirOrder) {
  const auto found = objects({"-f", "pos28,nE,nW,crc6", "--ber", "1e-2", "--ber", "1e-4"});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0]["ber"], json({1e-2, 1e-4}));
  EXPECT_NEAR(found[0]["p_undetected"][1].get<double>(), 1.187e-10, 5e-14);
  EXPECT_EQ(found[0]["structure"][0]["fault"], "lost_bit");
}

TEST(SafetyAnalyse, CountBeyondDoubles_IsText) {
  const auto found = objects({"-f", "pos64,crc3"});
  const json& weights = found[0]["weights"];
  EXPECT_TRUE(weights[3].is_number_unsigned());
  EXPECT_TRUE(weights[33].is_string());
}

TEST(SafetyAnalyse, RatePerHour_IsProbabilityTimesFrames) {
  const auto found = objects(
      {"-f", "pos24,nE,nW,lc6,crc16", "--ber", "1e-2", "--rate", "1kHz", "--limit", "1e-3"});
  ASSERT_EQ(found[0]["word"], "SPW");
  const double p = found[0]["p_undetected"];
  EXPECT_NEAR(found[0]["per_hour"].get<double>() / (p * 3.6e6), 1, 1e-12);
  const auto again = objects(
      {"-f", "pos24,nE,nW,lc6,crc16", "--ber", found[0]["ber_at_limit"].dump(), "--rate", "1kHz"});
  EXPECT_NEAR(again[0]["per_hour"].get<double>(), 1e-3, 1e-9);
}

TEST(SafetyAnalyse, FewerComparedBits_PassMore) {
  const std::vector<std::string> all = {"-f", "fs-32-32", "--ber", "1e-2"};
  std::vector<std::string> few = all;
  few.insert(few.end(), {"--compare", "11"});
  const auto a = objects(all);
  const auto b = objects(few);
  EXPECT_EQ(a[2]["compared_bits"], 32);
  EXPECT_EQ(b[2]["compared_bits"], 11);
  EXPECT_LT(a[2]["p_undetected"], b[2]["p_undetected"]);
}

TEST(SafetyAnalyse, ForEyes_SaysWhatItIs) {
  const Ran ran = analyse({"-f", "fs-28-24"});
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("not a certificate"));
  EXPECT_THAT(ran.out, HasSubstr("A3 = 119, A4 = 958, A5 = 5845, A6 = 30392"));
  EXPECT_THAT(ran.out, HasSubstr("3 for 1..57, 2 from 58 on"));
  EXPECT_THAT(ran.out, HasSubstr("lost_start"));
  // Both figures of the pair say what they are.
  const std::size_t safe = ran.out.find("safe position");
  const std::size_t control = ran.out.find("control position");
  ASSERT_LT(safe, control);
  ASSERT_NE(control, std::string::npos);
  EXPECT_THAT(ran.out.substr(safe, control - safe), HasSubstr("3.882e-18 a frame at 0.01"));
  EXPECT_THAT(ran.out.substr(control), HasSubstr("2.245e-06 a frame at 0.01"));
  EXPECT_THAT(ran.out.substr(control), HasSubstr("only the CPW's CRC protects it"));
}

TEST(SafetyAnalyse, PairThatCannotBeCounted_IsToldAndTheWordsAreShown) {
  const Ran ran = analyse({"-f", "pos26,nE,crc16+pos26,nE,lc6,crc16", "--to", "jsonl"});
  EXPECT_EQ(ran.status, ExitStatus::done);
  EXPECT_THAT(ran.err, HasSubstr("more than 24 bits"));
  EXPECT_EQ(std::count(ran.out.begin(), ran.out.end(), '\n'), 2);
}

TEST(SafetyAnalyse, ToleranceAboveOne_AnalysesTheWordsAndSaysThatThePairIsMissing) {
  const Ran ran = analyse({"-f", "fs-36-28", "--tolerance", "2"});
  EXPECT_EQ(ran.status, ExitStatus::done);
  EXPECT_NE(ran.err.find("the two words are not analysed as a pair"), std::string::npos) << ran.err;
}

TEST(SafetyAnalyse, WrongUsage_IsOneLineAndStatus2) {
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{},
                                                    {"-f", "nonsense"},
                                                    {"-f", "fs-36-28", "--ber", "0"},
                                                    {"-f", "fs-36-28", "--ber", "0.6"},
                                                    {"-f", "fs-36-28", "--ber", "1e-3x"},
                                                    {"-f", "fs-36-28", "--tolerance", "256"},
                                                    {"-f", "fs-36-28", "--limit", "-1"}}) {
    expect_wrong_usage(analyse(arguments));
  }
}

}  // namespace analyse_test
}  // namespace biss::verbs
