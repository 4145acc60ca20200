#include "verbs/simulate/fault_option.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace biss::verbs {
namespace fault_option_test {

using sim::FaultKind;
using sim::FaultPlace;
using sim::FaultRule;
using sim::PlaceUnit;

FaultRule rule_of(const std::string& text) {
  const auto rule = read_fault(text);
  EXPECT_TRUE(rule.has_value()) << text;
  return rule.value_or(FaultRule{});
}

// A cycle of 40 clocks in an interval of 60, with 34 bits of payload.
sim::NominalCycle nominal() {
  return {.period = nanoseconds(100),
          .low_time = nanoseconds(50),
          .interval = nanoseconds(6'050),
          .clocks = 40,
          .data_clock = 4,
          .line_delay = nanoseconds(42),
          .payload_bits = 34};
}

std::string checked(const std::vector<std::string>& texts, std::uint64_t cycles = 100) {
  std::vector<FaultRule> rules;
  for (const std::string& text : texts) rules.push_back(rule_of(text));
  return wrong_faults(rules, nominal(), cycles);
}

TEST(FaultOption, RateCycleAndPlace_AreRead) {
  EXPECT_EQ(rule_of("flip:0.25").share, std::uint64_t{1} << 30U);
  EXPECT_FALSE(rule_of("flip:0.25").place);
  EXPECT_EQ(rule_of("cut@40").cycle, 40U);
  EXPECT_EQ(rule_of("cut@40").kind, FaultKind::cut);
  const FaultRule bit = rule_of("flip@100,bit=7");
  EXPECT_EQ(bit.cycle, 100U);
  EXPECT_EQ(bit.place, (FaultPlace{PlaceUnit::bit, 7'000}));
  EXPECT_EQ(rule_of("glitch_ma@0,clock=12.25").place, (FaultPlace{PlaceUnit::clock, 12'250}));
  EXPECT_EQ(rule_of("glitch_ma@0,clock=12.007").place, (FaultPlace{PlaceUnit::clock, 12'007}));
  const FaultRule rate = rule_of("flip:1,bit=0");
  EXPECT_EQ(rate.share, std::uint64_t{1} << 32U);
  EXPECT_EQ(rate.place, (FaultPlace{PlaceUnit::bit, 0}));
}

TEST(FaultOption, WhatIsNoRule_IsRefusedWithItsText) {
  for (const char* text : {"flip",
                           "flip:",
                           "flip@",
                           "flip:2",
                           "flip@-1",
                           "flip@1,",
                           "flip@1,7",
                           "flip@1,bit",
                           "flip@1,bit=",
                           "flip@1,bit=-1",
                           "flip@1,bit=1.",
                           "flip@1,bit=.5",
                           "flip@1,bit=1.2345",
                           "flip@1,bit=1.2x",
                           "flip@1,bit=0x10",
                           "flip@1,bits=1",
                           "flip@1,clock=1,bit=2",
                           "flip@1,bit=1000000001",
                           "flip,bit=1",
                           "flip:0.1@3"}) {
    const auto rule = read_fault(text);
    ASSERT_FALSE(rule.has_value()) << text;
    EXPECT_NE(rule.error().find("--fault: '" + std::string(text) + "' is not KIND:RATE"),
              std::string::npos)
        << text << ": " << rule.error();
  }
  EXPECT_EQ(read_fault("flop@1").error(), "--fault: no kind 'flop'; did you mean flip?");
}

TEST(FaultOption, PlacesThatExist_AreTaken) {
  EXPECT_EQ(checked({"flip@0,bit=0", "flip@99,bit=33", "burst@3,bit=32", "slo_low@4,bit=33.999",
                     "slo_low@5,clock=39.999", "lost_clock@4,clock=39", "ma_low:0.1,clock=0.5",
                     "glitch_ma_idle@7,clock=40", "glitch_slo_idle@7,clock=59.9"}),
            "");
}

TEST(FaultOption, PlaceBeyondTheFrame_SaysWhichThereAre) {
  EXPECT_EQ(checked({"flip@1,bit=34"}),
            "--fault: no bit=34 for flip; on this line it takes bit 0 to 33");
  EXPECT_EQ(checked({"burst@1,bit=33"}),
            "--fault: no bit=33 for burst; on this line it takes bit 0 to 32");
  EXPECT_EQ(checked({"cut:0.1,clock=40.5"}),
            "--fault: no clock=40.5 for cut; on this line it takes clock 0 to 39");
  EXPECT_EQ(checked({"glitch_ma_idle@1,clock=39"}),
            "--fault: no clock=39 for glitch_ma_idle; on this line it takes clock 40 to 59");
  EXPECT_EQ(checked({"glitch_ma_idle@1,clock=60"}),
            "--fault: no clock=60 for glitch_ma_idle; on this line it takes clock 40 to 59");
}

TEST(FaultOption, KindWithoutThatPlace_IsNamed) {
  for (const char* kind :
       {"late_start", "no_answer", "swap_ma", "swap_slo", "exchange", "nE", "nW", "frozen"}) {
    EXPECT_EQ(checked({std::string(kind) + "@1,clock=3"}),
              "--fault: " + std::string(kind) + " has no place: it affects the whole cycle");
  }
  EXPECT_EQ(checked({"flip@1,clock=3"}), "--fault: flip takes a bit, not a clock");
  EXPECT_EQ(checked({"lost_clock@1,bit=3"}), "--fault: lost_clock takes a clock, not a bit");
  EXPECT_EQ(checked({"flip@1,bit=3.5"}), "--fault: flip takes a whole bit, not bit=3.5");
  EXPECT_EQ(checked({"double_clock@1,clock=3.25"}),
            "--fault: double_clock takes a whole clock, not clock=3.25");
}

TEST(FaultOption, CycleThatIsNotThereOrNamedTwice_IsRefused) {
  EXPECT_EQ(checked({"flip@100"}), "--fault: no cycle 100 for flip; the last one is 99");
  EXPECT_EQ(checked({"flip@5,bit=1", "cut@5", "flip@5,bit=2"}),
            "--fault: flip is given twice for cycle 5; give each kind once");
  EXPECT_EQ(checked({"flip:0.1", "flip:0.2"}),
            "--fault: flip is given twice with a rate; give each kind once");
  EXPECT_EQ(checked({"flip:0.1", "flip@5", "flip@6"}), "");
}

TEST(FaultOption, EveryKind_HasAPlaceOrNone) {
  for (std::size_t k = 0; k < sim::simulated_fault_count; ++k) {
    const auto kind = static_cast<FaultKind>(k);
    const bool any = !places_of(kind, PlaceUnit::bit, nominal()).empty() ||
                     !places_of(kind, PlaceUnit::clock, nominal()).empty();
    EXPECT_EQ(any, sim::has_place(kind)) << sim::name_of(kind);
  }
}

TEST(FaultOption, Places_ArePrintedAsTheyAreGiven) {
  const std::vector<sim::InjectedFault> injected{{FaultKind::flip, {PlaceUnit::bit, 7'000}},
                                                 {FaultKind::cut, {PlaceUnit::clock, 12'250}},
                                                 {FaultKind::ma_low, {PlaceUnit::clock, 1'005}}};
  EXPECT_EQ(text_of(injected), "flip@bit=7;cut@clock=12.25;ma_low@clock=1.005");
  EXPECT_EQ(text_of(std::vector<sim::InjectedFault>{}), "");
}

}  // namespace fault_option_test
}  // namespace biss::verbs
