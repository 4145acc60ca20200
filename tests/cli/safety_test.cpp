// BiSS Safety on the wire: `simulate` injects each fault, `decode` names it.
#include <set>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::safety_test {

using Safety = InFolder;
using testing::HasSubstr;

std::vector<Row> decoded(const Folder& folder, const Words& made, const Words& read) {
  const std::string capture = folder.path("line.csv");
  run_ok(Words("simulate -o {}", capture) + made);
  return rows_of(run_ok(Words("decode {} --to csv", capture) + read).out);
}

std::size_t count(const std::vector<Row>& rows, const std::string& verdict) {
  std::size_t sum = 0;
  for (const Row& row : rows) sum += row.at("safety") == verdict ? 1U : 0U;
  return sum;
}

TEST_F(Safety, UndamagedEncoders_AreSafeFromTheThirdFrameOn) {
  for (const char* format : {"fs-32-32", "fs-28-24", "fs-36-28"}) {
    for (const char* motion : {"max", "random"}) {
      SCOPED_TRACE(std::string(format) + ' ' + motion);
      const auto rows = decoded(
          folder,
          Words("-f {} --motion {} --cycles 1000 --clock 10MHz --cable 20m --counter-start 60",
                format, motion),
          Words("-f {} --fail-on safety,any", format));
      ASSERT_EQ(rows.size(), 1000U);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        ASSERT_EQ(rows[i].at("safety"), i < 2 ? "starting" : "safe") << i;
      }
    }
  }
}

// The name of a configuration alone defines the format and the monitor.
TEST_F(Safety, EveryConfigurationsName_IsAFormat) {
  for (const char* name : {"fortis-fs-36-28-10nm", "fortis-fs-36-28-1nm", "rxm", "rxh", "rsm",
                           "rsh", "rlm", "rlh", "rum", "ruh", "lmm"}) {
    SCOPED_TRACE(name);
    const std::string capture = folder.path("named.csv");
    run_ok("simulate -f {} --cycles 20 -o {}", name, capture);
    const Outcome read = run_ok("decode {} -f {} --fail-on safety,any", capture, name);
    EXPECT_THAT(read.out + read.err, HasSubstr(name));
    run_ok("safety analyse -f {} --ber 0.01", name);
  }
}

// Renishaw's data sheet of BiSS Safety: MA from 250 kHz, ACK up to 16 us, a request every 31.25 us.
TEST_F(Safety, EveryNameOfRenishawsRows_HasTheDataSheetsTiming) {
  const std::string slow = folder.path("slow.csv");
  run_ok(
      "simulate -f pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0 --clock 5MHz --processing "
      "20us --cycles 20 -o {}",
      slow);
  for (const char* name :
       {"fs-36-28", "fortis-fs-36-28", "fortis-fs-36-28-10nm", "fortis-fs-36-28-1nm"}) {
    SCOPED_TRACE(name);
    const std::string capture = folder.path("named.csv");
    const auto simulate = [&](const char* clock, const char* rate) {
      return run("simulate -f {} --cycles 20 --clock {} --rate {} -o {}", name, clock, rate,
                 capture);
    };
    EXPECT_EQ(simulate("10MHz", "32kHz").status, 0);
    EXPECT_THAT(simulate("10MHz", "33kHz").err, HasSubstr("at most 32 kHz"));
    EXPECT_THAT(simulate("100kHz", "1kHz").err, HasSubstr("accepts 250 kHz"));
    EXPECT_EQ(run("decode {} -f {} --fail-on ack_range", slow, name).status, 1);
    EXPECT_THAT(run("safety line -f {} --cycles 100 --rate 33kHz", name).err,
                HasSubstr("at most 32 kHz"));
    run_ok("safety line -f {} --cycles 100 -o {}", name, folder.path("t"));
  }
}

// A fault of `simulate`, the number of rows from the injection to the reaction, and the verdicts
// that may be reported.
struct Committed {
  std::string kind;
  std::size_t reaction;
  std::set<std::string> verdicts;
};

class SafetyFault : public testing::TestWithParam<Committed> {};

TEST_P(SafetyFault, OnTheWire_IsNamedInTime) {
  const Folder folder;
  const Committed& fault = GetParam();
  for (const char* format : {"fs-32-32", "fs-28-24", "fs-36-28"}) {
    for (const char* seed : {"1", "2", "3", "4", "5", "6", "7", "8"}) {
      SCOPED_TRACE(std::string(format) + " seed " + seed);
      const auto rows = decoded(folder,
                                Words("-f {} --motion random --cycles 120 --seed {} --fault {}",
                                      format, seed, fault.kind + "@50"),
                                {"-f", format});
      ASSERT_EQ(rows.size(), 120U);
      const std::size_t shows = 50 + fault.reaction;
      for (std::size_t i = 2; i < shows; ++i) ASSERT_EQ(rows[i].at("safety"), "safe") << i;
      const std::string& told = rows[shows].at("safety");
      EXPECT_TRUE(fault.verdicts.contains(told)) << told;
      for (std::size_t i = 60; i < 120; ++i) ASSERT_EQ(rows[i].at("safety"), "safe") << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, SafetyFault,
    testing::Values(
        Committed{"flip", 0, {"cpw_crc", "spw_crc"}},
        // A burst that a CRC of 6 bits does not detect differs from the other word, or sets nE to
        // 0.
        Committed{"burst", 0, {"cpw_crc", "spw_crc", "comparison", "cpw_error"}},
        Committed{"repeat", 0, {"counter_repeated"}},
        Committed{"reorder", 0, {"counter_backwards"}}, Committed{"loss", 0, {"counter_skipped"}},
        Committed{"delay", 1, {"watchdog"}}, Committed{"insert", 0, {"counter_foreign"}},
        Committed{"masquerade", 0, {"spw_crc"}}, Committed{"other_encoder", 0, {"counter_foreign"}},
        Committed{"lc_frozen", 0, {"counter_repeated"}},
        // From 50 to 1: 14 counts ahead, across the roll-over.
        Committed{"lc_restart", 0, {"counter_foreign"}}, Committed{"no_answer", 0, {"no_frame"}},
        Committed{"nE", 0, {"cpw_error"}}),
    [](const auto& fault) { return fault.param.kind; });

TEST_F(Safety, CounterOfTheOtherRange_IsNamed) {
  const Words zero("-f fs-36-28 --cycles 300 --counter count_0_63");
  EXPECT_EQ(count(decoded(folder, zero, "-f fs-36-28"), "counter_mode"), 4U);
  EXPECT_EQ(count(decoded(folder, zero, "-f fs-36-28 --counter count_0_63"), "safe"), 298U);
  const auto learned = decoded(folder, zero, "-f fs-36-28 --counter learned");
  EXPECT_EQ(count(learned, "safe") + count(learned, "starting"), 300U);
  EXPECT_GT(count(learned, "safe"), 150U);
  const Words one("-f fs-36-28 --cycles 300");
  EXPECT_GT(count(decoded(folder, one, "-f fs-36-28 --counter count_0_63"), "counter_mode"), 3U);
}

TEST_F(Safety, CounterPeriodAndWorstDifference_StandInTheSummary) {
  const std::string capture = folder.path("line.csv");
  run_ok(
      "simulate -f fs-36-28 --cycles 200 --counter count_0_63 --motion constant --drift "
      "2 -o {}",
      capture);
  const Outcome read =
      run("decode {} -f fs-36-28 --counter learned -o {}", capture, folder.path("rows"));
  EXPECT_THAT(read.err, HasSubstr("period 64, seen 3 times"));
  EXPECT_THAT(read.err, HasSubstr("worst difference 2, 1 allowed"));
}

// 256 counts of the 36-bit word are one of the 28-bit word.
TEST_F(Safety, WordsThatDriftApart_AreSafeUpToTheTolerance) {
  const Words made("-f fs-36-28 --cycles 100 --motion constant --drift 16");
  for (const auto& [tolerance, apart] : {std::pair{1, 16 * 2}, {3, 16 * 4}}) {
    const auto rows =
        decoded(folder, made, Words("-f fs-36-28 --tolerance {}", std::to_string(tolerance)));
    std::size_t last_safe = 0;
    for (std::size_t i = 2; i < rows.size() && rows[i].at("safety") == "safe"; ++i) last_safe = i;
    // The place between two counts of the short word is random.
    EXPECT_NEAR(static_cast<double>(last_safe), apart - 9.0, 9.0);
    EXPECT_EQ(count(rows, "comparison"), rows.size() - 1 - last_safe);
  }
  EXPECT_EQ(count(decoded(folder, made, "-f fs-36-28 --compare-bits 20"), "safe"), 98U);
}

TEST_F(Safety, LatchedFault_HoldsToTheEnd) {
  const auto rows =
      decoded(folder, "-f fs-28-24 --cycles 100 --fault repeat@50", "-f fs-28-24 --latch");
  EXPECT_EQ(rows[50].at("safety"), "counter_repeated");
  EXPECT_EQ(count(rows, "latched"), 49U);
}

// At any rate the watchdog and the shortest gap fit each other, with and without a named encoder.
TEST_F(Safety, CapturesAtLowRates_AreSafe) {
  const std::string words = "pos20,nE,nW,crc6+pos19,nE,nW,lc6,crc16";
  for (const char* rate : {"9kHz", "700Hz", "500Hz", "2Hz"}) {
    for (const std::string& format : {std::string("fs-36-28"), words}) {
      SCOPED_TRACE(rate + format);
      const auto rows =
          decoded(folder, Words("-f {} --rate {} --cycles 100 --timeout adaptive", format, rate),
                  Words("-f {} --timeout adaptive --fail-on safety", format));
      EXPECT_EQ(count(rows, "safe"), 98U);
    }
  }
}

TEST_F(Safety, WatchdogInWhichAPeriodCanBeLost_IsRefused) {
  const std::string capture = folder.path("line.csv");
  run_ok("simulate -f fs-36-28 --rate 500Hz --cycles 100 -o {}", capture);
  const auto read = [&](const Words& more) {
    return run(Words("decode {} -f fs-36-28 --fail-on safety", capture) + more);
  };
  EXPECT_EQ(read({}).status, 0);
  EXPECT_EQ(read({"--shortest-gap", "48us"}).status, 0);
  EXPECT_EQ(read({"--watchdog", "50ms"}).status, 0);
  for (const Words& more :
       {Words("--shortest-gap 47us"), Words("--shortest-gap 0"),
        Words("--watchdog 50ms --shortest-gap 793us"), Words("--watchdog 130ms")}) {
    EXPECT_THAT(read(more), fails(2, "shorter than 63 times --shortest-gap")) << more[1];
  }
  EXPECT_EQ(read({"--watchdog", "50ms", "--shortest-gap", "794us"}).status, 0);
}

TEST_F(Safety, FailOn_KnowsTheVerdicts) {
  const std::string capture = folder.path("line.csv");
  run_ok("simulate -f fs-28-24 --cycles 100 --fault loss@50 -o {}", capture);
  const auto status = [&](const std::string& word) {
    return run("decode {} -f fs-28-24 --fail-on {}", capture, word).status;
  };
  EXPECT_EQ(status("safety"), 1);
  EXPECT_EQ(status("counter_skipped"), 1);
  EXPECT_EQ(status("comparison,counter_repeated"), 0);
  EXPECT_EQ(status("nothing"), 2);
  EXPECT_EQ(run("decode {} --fail-on safety", capture).status, 1);
  EXPECT_EQ(run("decode {} -f none --fail-on safety", capture).status, 2);
  EXPECT_EQ(run("decode {} -f pos26,nE,nW,crc6 --fail-on safety", capture).status, 2);
}

TEST_F(Safety, OtherFormatsAndOff_LeaveTheColumnEmpty) {
  for (const Row& row : decoded(folder, "-f resolute-26", "-f resolute-26")) {
    EXPECT_EQ(row.at("safety"), "");
  }
  for (const Row& row : decoded(folder, "-f fs-28-24", "-f fs-28-24 --safety off")) {
    EXPECT_EQ(row.at("safety"), "");
  }
}

TEST_F(Safety, WrongOptions_AreRefused) {
  const std::string capture = folder.path("line.csv");
  run_ok("simulate -f fs-28-24 -o {}", capture);
  const auto refused = [&](const Words& more) {
    EXPECT_THAT(run(Words("decode {} -f fs-28-24", capture) + more), refuses(2, more[0]));
  };
  refused("--compare-bits 25");
  refused("--start-frames 1");
  refused("--watchdog 1s");
  refused("--safety rsx");
  EXPECT_EQ(run("decode {} -f pos26,nE,nW,crc6 --latch", capture).status, 2);
}

}  // namespace biss::verbs::safety_test
