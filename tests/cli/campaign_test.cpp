// biss safety campaign: killed and resumed, in shards, with any number of threads.
#include <cmath>
#include <random>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::campaign_test {

using Campaign = InFolder;

Words campaign(const Words& more) {
  return Words(
             "safety campaign -f rxm --fault flips:0.1 --fault burst:16 --fault slo_low --fault "
             "lost_start --fault flips:0.5:fitting --frames 1000003 --seed 11 --to csv "
             "--no-importance") +
         more;
}

// A short campaign that has saved its state.
Words saved_campaign(const std::string& state) {
  const Words arguments(
      "safety campaign -f rxm --fault flips:0.1 --frames 1000 --no-importance --to csv --state {}",
      state);
  run_ok(arguments);
  return arguments;
}

const std::string& whole() {
  static const std::string table = run(campaign("--threads 2")).out;
  return table;
}

TEST_F(Campaign, KilledAtAnyTime_GoesOnToTheSameTable) {
  const std::string state = folder.path("state.json");
  std::mt19937 random(20261121);
  int kills = 0;
  for (; kills < 12; ++kills) {
    const auto time = std::chrono::microseconds(20'000 + random() % 100'000);
    const Words words("--threads 2 --state {} --save-every 1ms -o {}", state,
                      folder.path("early.csv"));
    if (run_for(time, "KILL", campaign(words)).status != 128 + SIGKILL) break;
  }
  EXPECT_GT(kills, 0);
  EXPECT_EQ(run_ok(campaign(Words("--threads 3 --state {}", state))).out, whole());
  EXPECT_EQ(run(campaign({"--state", state})).out, whole());
}

TEST_F(Campaign, InterruptedBeforeTheFirstSave_KeepsItsProgress) {
  const std::string state = folder.path("state.json");
  const auto arguments = campaign(Words("--state {} --save-every 1000s", state));
  // After the command handles signals, the first one makes it write a state.
  int status = 0;
  for (auto time = std::chrono::milliseconds(50); !std::filesystem::exists(state); time *= 2) {
    ASSERT_LT(time, std::chrono::minutes(2));
    status = run_for(time, "INT", arguments).status;
  }
  EXPECT_TRUE(status < 128 || status == 128 + SIGINT) << status;
  EXPECT_EQ(run(arguments).out, whole());
}

TEST_F(Campaign, SevenShardsMerged_GiveTheSameTable) {
  Words merge("safety campaign merge --to csv");
  for (const char* shard : {"1/7", "2/7", "3/7", "4/7", "5/7", "6/7", "7/7"}) {
    const std::string state = folder.path(std::string(1, shard[0]) + ".json");
    const Outcome part = run_ok(campaign(Words("--shard {} --state {}", shard, state)));
    EXPECT_NE(part.out, whole());
    if (shard[0] == '7') {
      EXPECT_EQ(run(merge).status, 1) << "a part is missing";
    }
    merge.push_back(state);
  }
  EXPECT_EQ(run_ok(merge).out, whole());
  merge.push_back(folder.path("3.json"));
  EXPECT_EQ(run(merge).status, 3) << "a part twice";
}

TEST_F(Campaign, Rows_HaveTheKeysOfTheContract) {
  EXPECT_TRUE(
      whole().starts_with("fault,frames,accepted_cpw,accepted_spw,accepted_both,"
                          "accepted_monitor,wrong,rate,theory,"));
  const auto rows = rows_of(whole());
  ASSERT_EQ(rows.size(), 5U);
  for (const Row& row : rows) EXPECT_EQ(row.at("frames"), "1000003");
  EXPECT_EQ(rows[0].at("fault"), "flips:0.1");
  EXPECT_EQ(rows[4].at("cpw_rate"), "") << "fitting draws say nothing of a checksum alone";
  EXPECT_GT(std::stod(rows[4].at("effective")), 1000);
  EXPECT_LT(std::abs(std::stod(rows[4].at("sigma"))), 5);
}

TEST_F(Campaign, JsonLines_HaveNumbers) {
  const Outcome lines =
      run_ok("safety campaign -f rxm --fault flips:0.1 --frames 70000 --no-importance --to jsonl");
  for (const char* key : {"rate", "theory", "low", "high", "cpw_sigma", "effective"}) {
    const auto at = lines.out.find("\"" + std::string(key) + "\":");
    ASSERT_NE(at, std::string::npos) << key;
    EXPECT_NE(std::string("-0123456789").find(lines.out[at + std::string(key).size() + 3]),
              std::string::npos)
        << lines.out;
  }
}

TEST_F(Campaign, MissedFrame_IsShownAgainByItsNumber) {
  const std::string missed = rows_of(whole())[0].at("missed");
  ASSERT_FALSE(missed.empty());
  const Outcome shown =
      run_ok("safety campaign -f rxm --fault flips:0.1 --seed 11 --replay {} --to csv",
             missed.substr(0, missed.find(';')));
  const auto rows = rows_of(shown.out);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].at("verdict"), "safe");
  EXPECT_NE(rows[0].at("position"), rows[0].at("position_read"));
  EXPECT_NE(rows[0].at("cpw_sent"), rows[0].at("cpw_read"));
}

TEST_F(Campaign, StateOfAnotherCampaign_IsRefusedAndKept) {
  const std::string state = folder.path("state.json");
  run_ok(campaign(Words("--shard 1/20 --state {}", state)));
  const std::string before = content_of(state);
  EXPECT_EQ(run(campaign(Words("--seed 12 --state {}", state))).status, 2) << "--seed twice";
  EXPECT_EQ(run("safety campaign -f rxm --fault flips:0.1 --state {}", state).status, 3);
  EXPECT_EQ(content_of(state), before);
  const std::string broken = folder.file("broken.json", before.substr(0, before.size() / 2));
  EXPECT_EQ(run(campaign({"--state", broken})).status, 3);
}

TEST_F(Campaign, StateWithACountThatCannotBe_IsRefused) {
  const std::string state = folder.path("state.json");
  const Words arguments = saved_campaign(state);
  const std::string text = content_of(state);
  const std::size_t at = text.find("\"cpw\":[[") + 9;
  const std::size_t comma = text.find(',', at);
  const std::size_t end = text.find(']', at);
  for (const std::string count : {"-5", "99999999", "1e308"}) {
    const std::string wrong = text.substr(0, comma + 1) + count + text.substr(end);
    folder.file("state.json", wrong);
    EXPECT_THAT(run(arguments), refuses(3, "flips:0.1: 'cpw' is")) << count;
    EXPECT_EQ(run("safety campaign merge {}", state).status, 3);
    EXPECT_EQ(content_of(state), wrong);
  }
}

TEST_F(Campaign, ChangedByteOfAState_IsRefused) {
  const std::string state = folder.path("state.json");
  const Words arguments = saved_campaign(state);
  const std::string text = content_of(state);
  EXPECT_EQ(run(arguments).status, 0) << "as it was written";
  for (std::size_t at = 0; at < text.size(); at += 3) {
    std::string changed = text;
    changed[at] = changed[at] == '1' ? '2' : '1';
    folder.file("state.json", changed);
    EXPECT_EQ(run(arguments).status, 3) << at << " of " << changed;
    EXPECT_EQ(content_of(state), changed) << "a refused state is not overwritten";
  }
  // The text of an older version.
  folder.file("state.json", text.substr(0, text.find(",\n\"checksum\"")) + "}\n");
  EXPECT_THAT(run(arguments), fails(3, "not a usable campaign state: its checksum is missing"));
}

TEST_F(Campaign, ReplayAfterTheLastFrame_IsReported) {
  const auto replay = [](const std::string& fault, const std::string& index) {
    return run("safety campaign -f rxm --fault {} --frames 5000000 --replay {} --to csv", fault,
               index);
  };
  EXPECT_EQ(replay("flips:0.1", "4999999").err, "");
  EXPECT_EQ(replay("flips:0.1:fitting", "4194303").err, "");
  const Outcome behind = ok(replay("flips:0.1", "5000000"));
  EXPECT_THAT(behind.err, testing::HasSubstr("frame 5000000 is not below the 5000000 of --frames"));
  EXPECT_EQ(rows_of(behind.out).size(), 1U);
}

TEST_F(Campaign, CatalogueName_IsMonitoredByTheFirstConfigurationOfItsWords) {
  const auto table = [](const std::string& format) {
    return run("safety campaign -f {} --fault burst:16 --frames 100000 --to csv", format);
  };
  EXPECT_EQ(ok(table("fortis-fs-36-28")).out, table("fs-36-28").out);
}

TEST_F(Campaign, WrongUsage_IsNamed) {
  for (const Words& more :
       {Words(), Words("-f resolute"), Words("-f pos26,nE,nW,crc6"), Words("-f rxm --fault flips"),
        Words("-f rxm --fault slo_low:60"), Words("-f rxm --fault burst:32:29"),
        Words("-f rxm --fault false_start:61"), Words("-f rxm --fault lost_start:0"),
        Words("-f rxm --shard 0/7"), Words("-f rxm --shard 8/7"),
        Words("-f rxm --shard 6/18446744073709551615"), Words("-f rxm --replay 1"),
        Words("-f rxm --fault flips:0.1:fitting --replay 4194304"),
        Words("-f rxm --fault burst:16 --replay 70368744177664")}) {
    EXPECT_THAT(run(Words("safety campaign") + more), refuses(2, ""))
        << testing::PrintToString(more);
  }
  EXPECT_THAT(run("safety campaign -f rxm --save-every 1"), fails(2, "--save-every: '1': no unit"));
}

TEST_F(Campaign, StateThatCannotBeRead_IsNamed) {
  const auto with_state = [](const std::string& path) {
    return Words("safety campaign -f fs-36-28 --frames 100 --state {}", path);
  };
  EXPECT_THAT(run(with_state("/dev/zero")), refuses(3, "/dev/zero: it is larger than 64 MiB"));
  EXPECT_THAT(run(with_state(folder.path(""))), refuses(3, "it is a directory"));
  EXPECT_THAT(run("safety campaign merge {}", folder.path("none")),
              refuses(3, "cannot open it: No such file"));
}

}  // namespace biss::verbs::campaign_test
