// biss safety sequences: the table, its verdict as exit status, threads, and repeated single
// events.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::sequences_test {

// Weak checksums, so that the theory is quick to compute and many events are accepted.
constexpr const char* weak = "pos12,nE,nW,crc5+pos10,nE,nW,lc6,crc6";

Outcome sequences(const std::string& format, const Words& more) {
  return run(Words("safety sequences -f {} --to csv", format) + more);
}

const Row* row_of(const std::vector<Row>& rows, const std::string& name,
                  const std::string& variant) {
  for (const Row& row : rows) {
    if (row.at("run") == name && row.at("variant") == variant) return &row;
  }
  return nullptr;
}

TEST(Sequences, UndamagedFrames_HaveNoFalseAlarmWithAnyCounter) {
  const std::vector<Row> rows = rows_of(
      ok(sequences("fs-36-28",
                   "--frames 500000 --kind undamaged --motion max --motion steps --motion creep"))
          .out);
  ASSERT_EQ(rows.size(), 12U);
  for (const Row& row : rows) {
    EXPECT_EQ(row.at("frames"), "500000");
    EXPECT_EQ(row.at("false_alarms"), "0");
    EXPECT_EQ(row.at("misread"), "0");
    EXPECT_EQ(row.at("result"), "ok");
    EXPECT_GT(std::stoul(row.at("position_wraps")), 3000U);
    EXPECT_GT(std::stoul(row.at("counter_wraps")), 7800U);
    EXPECT_EQ(row.at("events"), "");
  }
}

// The same for a format whose theory of corruption takes seconds, without that theory.
TEST(Sequences, SevenKindsWithStrongChecksums_AreToldWithinTheirCycles) {
  const Outcome given = ok(sequences(
      "fs-36-28",
      "--faults 10000 --kind repetition --kind sequence --kind loss --kind delay --kind insertion "
      "--kind masquerade --kind addressing"));
  EXPECT_EQ(rows_of(given.out).size(), 24U + 7U);
}

TEST(Sequences, EveryKindOfFault_IsToldWithinItsCycles) {
  const std::vector<Row> rows = rows_of(ok(sequences(weak, "--frames 0 --faults 10000")).out);
  for (const char* name : {"corruption", "repetition", "sequence", "loss", "delay", "insertion",
                           "masquerade", "addressing"}) {
    const Row* row = row_of(rows, name, "all");
    ASSERT_TRUE(row) << name;
    EXPECT_EQ(row->at("events"), "10000");
    EXPECT_EQ(row->at("late"), "0");
    EXPECT_EQ(row->at("unexpected"), "0");
    EXPECT_LE(std::stoul(row->at("worst_cycles")), std::stoul(row->at("bound_cycles")));
    EXPECT_LE(std::stoul(row->at("bound_cycles")), 1U);
    EXPECT_EQ(row->at("result"), "ok");
  }
  for (const char* name : {"sequence", "loss", "delay"}) {
    EXPECT_EQ(row_of(rows, name, "all")->at("accepted"), "0");
  }
}

TEST(Sequences, CounterOfTheOtherRange_HasARowThatNamesIt) {
  for (const auto& [monitor, encoder] :
       {std::pair{"count_0_63", "count_1_63"}, std::pair{"count_1_63", "count_0_63"}}) {
    const std::vector<Row> rows =
        rows_of(ok(sequences("fs-28-24", Words("--counter {} --encoder-counter {} --faults 2000",
                                               monitor, encoder)))
                    .out);
    ASSERT_EQ(rows.size(), 1U);
    EXPECT_EQ(rows[0].at("run"), "counter_mode");
    EXPECT_EQ(rows[0].at("counter"), monitor);
    EXPECT_EQ(rows[0].at("encoder_counter"), encoder);
    EXPECT_EQ(rows[0].at("verdicts"), "counter_mode:2000");
  }
}

TEST(Sequences, Threads_DoNotChangeTheTable) {
  const Words arguments(
      "--frames 70000 --faults 1500 --kind undamaged --kind insertion --kind loss");
  const std::string one = sequences("rum", arguments + Words("--threads 1")).out;
  EXPECT_EQ(one, sequences("rum", arguments + Words("--threads 3")).out);
  EXPECT_NE(one, sequences("rum", arguments + Words("--threads 1 --seed 2")).out);
}

TEST(Sequences, AcceptedEvent_IsShownAgain) {
  const Words arguments("--kind addressing --variant one_frame --faults 3000");
  const std::vector<Row> rows = rows_of(sequences("fs-36-28", arguments).out);
  ASSERT_EQ(rows.size(), 1U);
  const std::string odd = rows[0].at("odd");
  ASSERT_FALSE(odd.empty());
  const std::string index = odd.substr(0, odd.find(';'));
  const std::vector<Row> steps =
      rows_of(ok(sequences("fs-36-28", arguments + Words{"--replay", index})).out);
  ASSERT_GE(steps.size(), 4U);
  const Row& last = steps.back();
  EXPECT_EQ(last.at("index"), index);
  EXPECT_EQ(last.at("what"), "fault");
  EXPECT_EQ(last.at("verdict"), "safe");
  EXPECT_EQ(last.at("lc"), last.at("lc_read"));
  EXPECT_NE(last.at("position"), last.at("position_read"));
}

TEST(Sequences, UndamagedFrame_IsShownWithTheFourBefore) {
  const std::vector<Row> steps =
      rows_of(ok(sequences("rsm",
                           "--kind undamaged --motion creep --counter learned "
                           "--encoder-counter count_0_63 --frames 70000 --replay 66000"))
                  .out);
  ASSERT_EQ(steps.size(), 5U);
  for (const Row& step : steps) {
    EXPECT_EQ(step.at("verdict"), "safe");
    EXPECT_EQ(step.at("position"), step.at("position_read"));
  }
  EXPECT_EQ(steps[4].at("index"), "66000");
}

TEST(Sequences, CatalogueName_IsMonitoredByTheFirstConfigurationOfItsWords) {
  const Words few("--kind repetition --faults 3000");
  EXPECT_EQ(ok(sequences("fortis-fs-36-28", few)).out, sequences("fs-36-28", few).out);
}

TEST(Sequences, WrongUsage_IsTold) {
  const auto refused = [](const std::string& format, const Words& more, const std::string& what) {
    EXPECT_THAT(sequences(format, more), refuses(2, what));
  };
  refused("resolute-26", {}, "'resolute-26' is neither");
  refused("fs-36-28", "--kind theft", "theft");
  refused("fs-36-28", "--kind loss --variant theft", "nothing to run");
  refused("fs-36-28", "--kind loss --counter count_0_63 --encoder-counter count_1_63",
          "nothing to run");
  refused("fs-36-28", "--kind loss --replay 1", "single row");
  refused("fs-36-28", "--kind loss --variant not_called --faults 100 --replay 25", "single row");
}

}  // namespace biss::verbs::sequences_test
