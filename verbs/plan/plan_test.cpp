#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "cli/test_verb_harness.hpp"

namespace biss::verbs {
namespace plan_test {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

Ran plan(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "plan");
  return run_verb(arguments);
}

std::vector<json> objects(const Ran& ran) {
  EXPECT_EQ(ran.status, ExitStatus::done) << ran.err;
  std::vector<json> found;
  std::istringstream lines(ran.out);
  for (std::string line; std::getline(lines, line);) found.push_back(json::parse(line));
  return found;
}

json one(const std::string& format, const std::string& clock, const std::string& cable) {
  const auto found =
      objects(plan({"-f", format, "--clock", clock, "--cable", cable, "--to", "jsonl"}));
  return found.size() == 1 ? found.front() : json();
}

TEST(Plan, CableTable_IsTheDataSheets) {
  struct Row {
    std::uint32_t clock;
    json without;
    json with;
  };
  const std::vector<Row> rows = {{250'000, 95'000, 100'000},   {1'000'000, 20'000, 100'000},
                                 {1'500'000, 12'000, 100'000}, {2'000'000, 8'000, 100'000},
                                 {3'000'000, 4'000, 100'000},  {4'000'000, 2'000, 100'000},
                                 {5'000'000, 500, 100'000},    {10'000'000, nullptr, 50'000}};
  for (const char* const encoder : {"resolute-26", "fortis-36", "fs-36-28"}) {
    const auto found = objects(plan({"-f", encoder, "--to", "jsonl"}));
    ASSERT_EQ(found.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(found[i]["clock_hz"], rows[i].clock);
      EXPECT_EQ(found[i]["cable_max_mm_uncompensated"], rows[i].without) << rows[i].clock;
      EXPECT_EQ(found[i]["cable_max_mm_compensated"], rows[i].with) << rows[i].clock;
    }
  }
}

TEST(Plan, WithoutCable_SaysThatTimesAndBytesAreWithoutOne) {
  const std::string note = "compensation, cycle, request rate and SPI bytes without a cable";
  EXPECT_THAT(plan({"-f", "resolute-26"}).out, HasSubstr(note));
  EXPECT_THAT(plan({"-f", "resolute-26", "--clock", "10MHz"}).out, HasSubstr(note));
  const std::string out = plan({"-f", "resolute-26", "--cable", "50m"}).out;
  EXPECT_THAT(out, HasSubstr("50 m of cable\n"));
  EXPECT_THAT(out, Not(HasSubstr("without a cable")));
}

TEST(Plan, CableTableForEyes_ReadsLikeTheDataSheet) {
  const std::string out = plan({"-f", "resolute-26"}).out;
  EXPECT_THAT(out, HasSubstr(" 0.25  95 m           100 m "));
  EXPECT_THAT(out, HasSubstr(" 5.00  0.5 m          100 m "));
  EXPECT_THAT(out, HasSubstr("10.00  -              50 m "));
}

double frame_us(const std::string& format, const std::string& clock) {
  const json plan = one(format, clock, "0");
  return (plan["lat_ns"].get<double>() + plan["ack_ns"].get<double>() +
          plan["start_cds_ns"].get<double>() + plan["payload_ns"].get<double>() +
          plan["stop_ns"].get<double>()) /
         1000;
}

TEST(Plan, FramesOf32kHz_TakeThePublishedTimes) {
  EXPECT_DOUBLE_EQ(frame_us("resolute-18", "10MHz"), 19.1);
  EXPECT_DOUBLE_EQ(frame_us("fortis-36", "10MHz"), 20.9);
  EXPECT_DOUBLE_EQ(frame_us("resolute-18", "5MHz"), 22.2);
  EXPECT_DOUBLE_EQ(frame_us("fortis-36", "5MHz"), 25.8);
  EXPECT_DOUBLE_EQ(frame_us("resolute-18", "2MHz"), 31.5);
  EXPECT_DOUBLE_EQ(frame_us("fortis-36", "2MHz"), 40.5);
  EXPECT_DOUBLE_EQ(frame_us("resolute-18", "1MHz"), 47);
  EXPECT_DOUBLE_EQ(frame_us("fortis-36", "1MHz"), 65);
  EXPECT_DOUBLE_EQ(frame_us("fs-36-28", "10MHz"), 26.1);
  EXPECT_DOUBLE_EQ(frame_us("fs-32-32", "10MHz"), 26.1);
  EXPECT_DOUBLE_EQ(frame_us("fs-36-28", "5MHz"), 36.2);
  EXPECT_DOUBLE_EQ(frame_us("fs-32-32", "5MHz"), 36.2);
  EXPECT_DOUBLE_EQ(frame_us("fs-28-24", "5MHz"), 33.8);
}

TEST(Plan, RequestRate_Is32kHzExactlyWhereTheFrameFits) {
  EXPECT_EQ(one("fortis-36", "10MHz", "50m")["request_rate_max_hz"], 32'000);
  EXPECT_EQ(one("fortis-36", "5MHz", "100m")["request_rate_max_hz"], 32'000);
  EXPECT_LT(one("resolute-18", "2MHz", "0")["request_rate_max_hz"], 32'000);
  EXPECT_EQ(one("fs-36-28", "10MHz", "50m")["request_rate_max_hz"], 32'000);
  EXPECT_LT(one("fs-28-24", "5MHz", "0")["request_rate_max_hz"], 32'000);
}

// Renishaw's data sheet of BiSS Safety: ACK up to 16 us, 32 kHz.
TEST(Plan, EveryNameOfRenishawsSafetyRows_HasTheDataSheetsTiming) {
  for (const char* const name : {"fs-32-32", "fs-28-24", "fs-36-28", "fortis-fs-36-28",
                                 "fortis-fs-36-28-10nm", "fortis-fs-36-28-1nm"}) {
    SCOPED_TRACE(name);
    const json plan = one(name, "10MHz", "50m");
    EXPECT_EQ(plan["request_rate_max_hz"], 32'000);
    EXPECT_EQ(plan["cycle_ns"], 31'250);
    EXPECT_EQ(plan["ack_max_clocks"], 160);
    EXPECT_EQ(plan["ack_min_clocks"], 32);
    EXPECT_EQ(plan["line_delay_ns"], 542.5);
    const std::string page = plan_test::plan({"-f", name, "--clock", "10MHz", "--cable", "1m"}).out;
    EXPECT_EQ(page.rfind(name, 0), 0U) << page;
    EXPECT_THAT(page, testing::Not(HasSubstr("by Renishaw's rule")));
  }
}

TEST(Plan, LongCableAtAHighClock_CountsDelayInClocks) {
  const json plan = one("resolute-26", "10MHz", "50m");
  EXPECT_EQ(plan["line_delay_ns"], 542.5);
  EXPECT_EQ(plan["line_delay_milliclocks"], 5425);
  EXPECT_EQ(plan["compensation_needed"], 1);
  EXPECT_EQ(plan["margin_uncompensated_ns"], -492.5);
  EXPECT_EQ(plan["margin_compensated_ns"], 25);
  EXPECT_EQ(plan["sample_whole_clocks"], 5);
  EXPECT_EQ(plan["sample_rest_ns"], 92.5);
  EXPECT_EQ(plan["clocks_to_send"], 205);
  EXPECT_EQ(plan["spi_bytes"], 26);
  EXPECT_EQ(plan["cycle_ns"], 31'250);
  // SLO is seen high 542.5 ns later.
  EXPECT_EQ(plan["request_rate_seen_hz"], 31'453);
}

TEST(Plan, FrameThatOutlastsTheCycle_CountsTheReleaseThatIsAssumed) {
  const json plan = one("resolute-18", "250kHz", "0");
  EXPECT_EQ(plan["timeout_ns"], 6'000);
  EXPECT_EQ(plan["cycle_ns"], 36 * 4'000 + 6'000);
  const auto other = objects(plan_test::plan({"-f", "resolute-18", "--clock", "250kHz", "--cable",
                                              "0", "--release", "2", "--to", "jsonl"}));
  EXPECT_EQ(other.at(0)["timeout_ns"], 4'000);
  EXPECT_THAT(
      plan_test::plan({"-f", "resolute-18", "--clock", "250kHz", "--cable", "0"}).out,
      HasSubstr("cycle:31.25us ends within the frame: 3 half periods assumed, see --release"));
}

TEST(Plan, RateWhereSloMustBeSeen_IsNamedWithItsReason) {
  const auto page = [](const char* encoder) {
    return plan({"-f", encoder, "--clock", "5MHz", "--cable", "100m"}).out;
  };
  EXPECT_THAT(page("resolute-18"), HasSubstr("for a master that waits until it sees SLO high"));
  EXPECT_THAT(page("lenz-b3"), HasSubstr("over SPI: the clocks of the line delay"));
}

TEST(Plan, PageForEyes_SaysWhatToDo) {
  const Ran ran = plan({"-f", "resolute-26", "--clock", "10MHz", "--cable", "50m"});
  EXPECT_EQ(ran.err, "");
  EXPECT_THAT(ran.out, HasSubstr("resolute-26 (Renishaw RESOLUTE rotary, 26 bit)"));
  EXPECT_THAT(ran.out, HasSubstr("compensation      needed"));
  EXPECT_THAT(ran.out, HasSubstr("SPI               26 bytes"));
  EXPECT_THAT(ran.out, HasSubstr("request rate      32 kHz"));
}

TEST(Plan, ClockOrCableOutOfRange_IsAWarning) {
  const Ran clock = plan({"-f", "resolute-26", "--clock", "100kHz", "--cable", "1m"});
  EXPECT_EQ(clock.status, ExitStatus::done);
  EXPECT_EQ(clock.err,
            "biss: a clock of 100 kHz is outside the encoder's range of 250 kHz to 10 MHz\n");
  const Ran cable = plan({"-f", "resolute-26", "--clock", "10MHz", "--cable", "60m"});
  EXPECT_EQ(cable.err,
            "biss: 60 m of cable is too long: at 10 MHz the limit is 50 m with "
            "line-delay compensation\n");
  EXPECT_THAT(plan({"-f", "pos26", "--clock", "12MHz", "--cable", "1m"}).err,
              HasSubstr("no cable length is known for clocks above 10 MHz"));
}

TEST(Plan, Between5And10MHz_SaysWhichLengthItTook) {
  EXPECT_THAT(plan({"-f", "resolute-26", "--clock", "7MHz", "--cable", "1m"}).out,
              HasSubstr("no length is published between 5 and 10 MHz"));
}

TEST(Plan, RenishawsNotesOnCables_AreShown) {
  for (const char* const name : {"resolute-26", "fs-36-28", "fortis-fs-36-28-1nm"}) {
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{}, {"--clock", "10MHz", "--cable", "20m"}}) {
      std::vector<std::string> arguments{"-f", name};
      arguments.insert(arguments.end(), more.begin(), more.end());
      const std::string out = plan(arguments).out;
      EXPECT_THAT(out, HasSubstr("readhead cable and approved extension cable"));
      EXPECT_THAT(out, testing::ContainsRegex("5 V \\+-10 % +the supply at the readhead\n"));
      EXPECT_THAT(out, HasSubstr("its own delay is not in the lengths: give --master-delay"));
    }
  }
  EXPECT_THAT(plan({"-f", "lenz-b3"}).out, testing::Not(HasSubstr("cable notes")));
}

// The data sheet of BiSS Safety sends the reader to Renishaw, the data sheet of BiSS C limits the
// readhead's own cable of RESOLUTE. Neither has the note of the other.
TEST(Plan, NotesOnCables_AreThoseOfTheEncodersDataSheet) {
  const std::string ask = "above 50 m +ask Renishaw\n";
  const std::string own = "10 m at most +the readhead's own cable; the rest is extension cable\n";
  struct Row {
    const char* name;
    bool asks;
    bool limits;
  };
  for (const Row& row : {Row{"resolute-26", false, true}, Row{"resolute-linear-36", false, true},
                         Row{"fortis-36", false, false}, Row{"fortis-26", false, false},
                         Row{"fs-36-28", true, false}, Row{"fortis-fs-36-28", true, false},
                         Row{"fortis-fs-36-28-1nm", true, false}, Row{"lenz-b3", false, false}}) {
    for (const std::vector<std::string>& more :
         {std::vector<std::string>{}, {"--clock", "5MHz", "--cable", "60m"}}) {
      std::vector<std::string> arguments{"-f", row.name};
      arguments.insert(arguments.end(), more.begin(), more.end());
      const std::string out = plan(arguments).out;
      EXPECT_EQ(testing::Value(out, testing::ContainsRegex(ask)), row.asks) << row.name;
      EXPECT_EQ(testing::Value(out, testing::ContainsRegex(own)), row.limits) << row.name;
    }
  }
}

TEST(Plan, RowsThatTheDataSheetDoesNotHave_AreMarked) {
  const auto found = objects(plan({"-f", "resolute-26", "--to", "jsonl"}));
  ASSERT_EQ(found.size(), 8U);
  for (const json& row : found) {
    const int kilohertz = row["clock_hz"].get<int>() / 1000;
    const bool published = kilohertz == 250 || kilohertz == 1000 || kilohertz == 2000 ||
                           kilohertz == 5000 || kilohertz == 10'000;
    EXPECT_EQ(row["cable_lengths"], published ? "data sheet" : "interpolated") << kilohertz;
  }
  const std::string table = plan({"-f", "resolute-26"}).out;
  EXPECT_THAT(table, testing::ContainsRegex(" 1\\.50  12 m [^\n]* interpolated\n"));
  EXPECT_THAT(table, testing::ContainsRegex(" 2\\.00  8 m [^\n]* data sheet\n"));
  EXPECT_THAT(plan({"-f", "resolute-26", "--clock", "3MHz", "--cable", "1m"}).out,
              HasSubstr("no row for this clock: interpolated"));
  EXPECT_THAT(plan({"-f", "resolute-26", "--clock", "2MHz", "--cable", "1m"}).out,
              testing::Not(HasSubstr("interpolated")));
  EXPECT_EQ(one("lenz-b3", "2MHz", "1m")["cable_lengths"], "Renishaw's rule");
}

TEST(Plan, DelayOfTheMaster_ShortensTheCableAndMovesTheSample) {
  const auto with = [](const char* clock, const char* delay) {
    return objects(plan({"-f", "resolute-26", "--clock", clock, "--cable", "10m", "--master-delay",
                         delay, "--to", "jsonl"}))
        .at(0);
  };
  const json none = with("1MHz", "0");
  EXPECT_EQ(none, one("resolute-26", "1MHz", "10m"));
  EXPECT_EQ(none["line_delay_ns"], 142.5);
  const json late = with("1MHz", "100ns");
  EXPECT_EQ(late["master_delay_ns"], 100);
  EXPECT_EQ(late["line_delay_ns"], 242.5);
  EXPECT_EQ(late["cable_max_mm_uncompensated"], 10'000);
  EXPECT_EQ(late["cable_max_mm_compensated"], 100'000);
  EXPECT_EQ(late["compensation_needed"], 0);
  EXPECT_EQ(late["margin_uncompensated_ns"], 257.5);
  EXPECT_EQ(late["sample_rest_ns"], 742.5);
  EXPECT_EQ(late["cable_lengths"], "calculated");
  EXPECT_EQ(with("1MHz", "108ns")["compensation_needed"], 1);
  EXPECT_EQ(with("10MHz", "500ns")["clocks_to_send"].get<int>(),
            with("10MHz", "0")["clocks_to_send"].get<int>() + 5);
  const std::string page =
      plan({"-f", "resolute-26", "--clock", "1MHz", "--cable", "10m", "--master-delay", "100ns"})
          .out;
  EXPECT_THAT(page, HasSubstr("at most 42.5 ns, master 100 ns"));
  EXPECT_THAT(page, HasSubstr("its own delay of 100 ns is counted"));
}

TEST(Plan, AnotherMakersEncoder_SaysWhoseRuleItIs) {
  EXPECT_THAT(plan({"-f", "lenz-b3", "--clock", "5MHz", "--cable", "1m"}).out,
              HasSubstr("by Renishaw's rule"));
}

TEST(Plan, TimingOptionsAndSlaves_ChangeTheBudget) {
  const auto found = objects(
      plan({"-f", "pos24,nE,nW,crc6+pos12,nE,nW,crc6+pos8", "--ack-clocks", "4", "--timeout",
            "static:13.2us", "--clock", "5MHz", "--cable", "0", "--slaves", "3", "--to", "jsonl"}));
  ASSERT_EQ(found.size(), 1U);
  // LAT, ACK, START, CDS, data and CRC, STOP; ACK has a clock for each further encoder.
  EXPECT_EQ(found[0]["frame_clocks"], 1 + (4 + 2) + 2 + (32 + 20 + 8) + 1);
  EXPECT_EQ(found[0]["ack_ns"], (4 + 2) * 200);
  EXPECT_EQ(found[0]["ack_min_clocks"], 4 + 2);
  EXPECT_EQ(found[0]["ack_max_clocks"], 4 + 2);
  EXPECT_EQ(found[0]["timeout_ns"], 13'200);
}

TEST(Plan, MoreSlavesThanChannels_AreRefused) {
  const Ran ran = plan({"-f", "resolute-26", "--slaves", "3"});
  EXPECT_EQ(ran.status, ExitStatus::usage);
  EXPECT_EQ(ran.out, "");
  EXPECT_THAT(ran.err, HasSubstr("--slaves '3': 1 to 1, as many as the format has channels"));
}

TEST(Plan, ClocksTheEncoderDoesNotTake_AreNotListed) {
  const auto found = objects(plan({"-f", "faulhaber-aemt", "--to", "jsonl"}));
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found.back()["clock_hz"], 2'000'000);
  // None of the usual rates matches: all are shown.
  EXPECT_EQ(objects(plan({"-f", "pos24", "--clock-max", "100kHz", "--to", "jsonl"})).size(), 8U);
}

TEST(Plan, WrongUsage_IsOneLineAndStatus2) {
  const std::vector<std::vector<std::string>> wrong = {
      {"--clock", "1MHz"},
      {"-f", "nothing"},
      {"-f", "pos26", "--clock", "0"},
      {"-f", "pos26", "--cable", "-1m"},
      {"-f", "pos26", "--slaves", "0"},
      {"-f", "pos26", "--slaves", "9"},
      {"-f", "pos26", "--timeout", "never"},
      {"-f", "pos26", "--release", "1"},
      {"-f", "pos26", "--master-delay", "30"},
      {"-f", "pos26", "--master-delay", "41us"},
      {"-f", "pos26", "--release", "256"},
      {"-f", "pos26", "--to", "csv"},
  };
  for (const auto& arguments : wrong) expect_wrong_usage(plan(arguments));
}

}  // namespace plan_test
}  // namespace biss::verbs
