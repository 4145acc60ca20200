// `biss simulate --ma-from` and `--slo-from`: recorded masters with a simulated encoder, recorded
// encoders with a simulated master.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/cli/reference_captures.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs {
namespace replay_test {

class RecordedCaptures : public testing::TestWithParam<std::string> {};

TEST_P(RecordedCaptures, EveryCompleteRequest_IsAnsweredWithAFrame) {
  for (const ReferenceCapture& capture : reference_captures()) {
    SCOPED_TRACE(capture.path);
    const Folder folder;
    const std::string answered = folder.path("answered.vcd");
    const std::string truth_path = folder.path("truth.csv");
    const Outcome made = run({"simulate", "-f", capture.format, "--cable", "20m", "--ma-from",
                              capture.path + GetParam(), "-o", answered, "--truth", truth_path});
    ASSERT_EQ(made.status, 0) << made.err;
    const Outcome decoded = run({"decode", "-f", capture.format, answered, "--to", "csv"});
    ASSERT_EQ(decoded.status, 0) << decoded.err;
    const auto rows = rows_of(decoded.out);
    const auto truth = rows_of(content_of(truth_path));
    ASSERT_EQ(rows.size(), capture.frames.size());
    ASSERT_EQ(truth.size(), capture.frames.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      SCOPED_TRACE(i);
      EXPECT_EQ(rows[i].at("status"), "ok");
      EXPECT_EQ(rows[i].at("position"), truth[i].at("position"));
      EXPECT_EQ(rows[i].at("line_delay_ns"), "200");
      EXPECT_EQ(truth[i].at("faults"), "");
      EXPECT_DOUBLE_EQ(std::stod(rows[i].at("time_ns")), capture.frames[i].time_ns);
    }
  }
}

TEST_P(RecordedCaptures, RecordedAnswers_AreReadByOurMaster) {
  for (const ReferenceCapture& capture : reference_captures()) {
    SCOPED_TRACE(capture.path);
    const Folder folder;
    const std::string readings = folder.path("readings.csv");
    const Outcome made =
        run({"simulate", "-f", capture.format, "--slo-from", capture.path + GetParam(), "-o",
             folder.path("line.vcd"), "--readings", readings});
    ASSERT_EQ(made.status, 0) << made.err;
    const auto rows = rows_of(content_of(readings));
    ASSERT_EQ(rows.size(), capture.frames.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      SCOPED_TRACE(i);
      const ReferenceFrame& sent = capture.frames[i];
      EXPECT_EQ(rows[i].at("status"), sent.good ? "ok" : "crc");
      EXPECT_EQ(rows[i].at("crc_ok"), sent.good ? "1" : "0");
      EXPECT_EQ(rows[i].at("position"), sent.good ? std::to_string(sent.position) : "");
      EXPECT_EQ(rows[i].at("nE"), sent.good ? sent.nE : "");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, RecordedCaptures, testing::Values(".vcd", ".csv"),
                         [](const auto& name) { return name.param.substr(1); });

// A simulated capture: 20 requests at 2 MHz.
std::string simulated(const Folder& folder) {
  const std::string path = folder.path("master.vcd");
  EXPECT_EQ(run({"simulate", "-f", "resolute-26", "--clock", "2MHz", "--cycles", "20", "-o", path})
                .status,
            0);
  return path;
}

TEST(Replay, CaptureOfMaAlone_IsAnswered) {
  const Folder folder;
  const std::string master =
      folder.file("ma.csv", "time_ns,clk\n0,1\n10000,0\n10500,1\n11000,0\n11500,1\n12000,0\n");
  const Outcome outcome =
      run({"simulate", "-f", "pos12,crc6", "--ma-from", master, "-o", folder.path("out.csv")});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("1 requests, 0 answered up to STOP, 1 cut by the master"),
            std::string::npos)
      << outcome.err;
  const auto rows = rows_of(content_of(folder.path("out.csv")));
  bool fell = false;
  for (Row row : rows) fell = fell || (row["SLO"] == "0" && std::stod(row["time_ns"]) == 11'500);
  EXPECT_TRUE(fell);
}

// A master that clocks until START and then reads 12 bits, CRC6 and STOP; without START it stops
// after 8 clocks. Times are in nanoseconds. `slo` holds the times of SLO's edges, the first one
// falling.
std::string waiting_master(const std::vector<double>& slo) {
  const auto level = [&slo](double time) {
    const auto edges = std::count_if(slo.begin(), slo.end(), [=](double at) { return at < time; });
    return edges % 2 == 0;
  };
  std::string rows = "time_ns,MA\n0,1\n";
  for (int request = 0; request < 3; ++request) {
    const double begin = 10'000 + 100'000 * request;
    bool acknowledged = false;
    int left = 8;
    for (int clock = 0; left != 0; ++clock, --left) {
      const double rise = begin + 500 + 1000 * clock;
      rows += std::to_string(rise - 500) + ",0\n" + std::to_string(rise) + ",1\n";
      const bool high = level(rise);
      if (acknowledged && high) {
        left = 1 + 12 + 6 + 1;
        acknowledged = false;
      } else if (clock < 8 && !high) {
        acknowledged = true;
      }
      if (clock >= 8) acknowledged = false;
    }
  }
  return rows;
}

// The times of SLO's edges in a capture that --ma-from has written.
std::vector<double> slo_edges(const std::string& path) {
  std::vector<double> edges;
  bool before = true;
  for (Row row : rows_of(content_of(path))) {
    const bool level = row["SLO"] == "1";
    if (level != before) edges.push_back(std::stod(row["time_ns"]));
    before = level;
  }
  return edges;
}

TEST(Replay, MasterThatWaitsForStart_IsNamedAndTheHintHelps) {
  const Folder folder;
  const std::string out = folder.path("out.csv");
  const std::string master = folder.file("ma.csv", waiting_master({}));
  const std::vector<std::string> arguments{"simulate", "-f", "pos12,crc6", "--ma-from",
                                           master,     "-o", out};
  const Outcome first = run(arguments);
  EXPECT_EQ(first.status, 0) << first.err;
  EXPECT_NE(first.err.find("3 requests, 0 answered up to STOP, 3 cut by the master"),
            std::string::npos);
  EXPECT_NE(first.err.find("If it waits for START, feed it the SLO of '" + out + "'"),
            std::string::npos)
      << first.err;
  folder.file("ma.csv", waiting_master(slo_edges(out)));
  const Outcome second = run(arguments);
  EXPECT_NE(second.err.find("3 requests, 3 answered up to STOP"), std::string::npos) << second.err;
  EXPECT_EQ(second.err.find("waits for START"), std::string::npos) << second.err;
}

TEST(Replay, Rerun_RunsTheMasterUntilEveryRequestIsAnswered) {
  const Folder folder;
  const std::string out = folder.path("out.csv");
  const std::string master = folder.file("ma.csv", waiting_master({}));
  const std::vector<std::string> arguments{"simulate", "-f", "pos12,crc6", "--ma-from",
                                           master,     "-o", out};
  EXPECT_EQ(run(arguments).status, 0);
  const std::string again = folder.file("again.csv", waiting_master(slo_edges(out)));

  auto with = [&](const std::string& command) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--rerun", command});
    return run(all);
  };
  const Outcome outcome = with("cp '" + again + "' '" + master + "'");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("3 requests, 3 answered up to STOP"), std::string::npos)
      << outcome.err;
  EXPECT_EQ(run({"decode", "-f", "pos12,crc6", out}).status, 0);

  folder.file("ma.csv", waiting_master({}));
  const Outcome useless = with("true");
  EXPECT_EQ(useless.status, 1);
  EXPECT_NE(useless.err.find("the master still ends requests before STOP"), std::string::npos)
      << useless.err;
  const Outcome failed = with("exit 7");
  EXPECT_EQ(failed.status, 3);
  EXPECT_NE(failed.err.find("--rerun: the command failed: 'exit 7'"), std::string::npos)
      << failed.err;
}

TEST(Replay, Positions_AreSentInTurn) {
  const Folder folder;
  const std::string master = simulated(folder);
  const std::string truth = folder.path("truth.csv");
  const auto with = [&](const std::string& list) {
    return run({"simulate", "-f", "resolute-26", "--ma-from", master, "--positions",
                folder.file("positions.txt", list), "-o", folder.path("out.vcd"), "--truth",
                truth});
  };
  const Outcome outcome = with("# corners\n0\n0x3FFFFFF # the last one\n\n4711\n");
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = rows_of(content_of(truth));
  ASSERT_EQ(rows.size(), 20U);
  const std::vector<std::string> sent{"0", "67108863", "4711"};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at("position"), sent[i % sent.size()]) << i;
  }
  const auto decoded =
      rows_of(run({"decode", "-f", "resolute-26", folder.path("out.vcd"), "--to", "csv"}).out);
  ASSERT_EQ(decoded.size(), 20U);
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    EXPECT_EQ(decoded[i].at("position"), sent[i % sent.size()]) << i;
  }
  EXPECT_EQ(with("0\n67108864\n").status, 3);
  EXPECT_NE(with("0\n67108864\n").err.find("line 2: '67108864'"), std::string::npos);
  EXPECT_NE(with("# nothing\n").err.find("no position"), std::string::npos);
}

TEST(Replay, EncoderThatIsNotReady_IsNamedInSummaryAndTruth) {
  const Folder folder;
  const std::string truth = folder.path("truth.csv");
  const Outcome outcome =
      run({"simulate", "-f", "resolute-26", "--timeout", "cycle:1ms", "--ma-from",
           simulated(folder), "-o", folder.path("out.vcd"), "--truth", truth});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("19 before the encoder was ready"), std::string::npos) << outcome.err;
  auto rows = rows_of(content_of(truth));
  ASSERT_EQ(rows.size(), 20U);
  EXPECT_EQ(rows[0]["faults"], "");
  EXPECT_EQ(rows[1]["faults"], "not_ready");
  EXPECT_EQ(rows[1]["position"], "");
}

TEST(Replay, AnotherClockThanTheRecordedOne_ReadsNoFrame) {
  const Folder folder;
  const std::string readings = folder.path("readings.csv");
  const Outcome outcome =
      run({"simulate", "-f", "resolute-26", "--clock", "3MHz", "--slo-from", simulated(folder),
           "-o", folder.path("out.vcd"), "--readings", readings});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  const auto rows = rows_of(content_of(readings));
  ASSERT_EQ(rows.size(), 20U);
  for (Row row : rows) {
    EXPECT_NE(row["status"], "ok");
    EXPECT_EQ(row["position"], "");
    EXPECT_EQ(row["crc_ok"], row["status"] == "crc" ? "0" : "");
  }
}

TEST(Replay, FirstChannelWithoutAPosition_LeavesThatOfTheSecondOne) {
  const Folder folder;
  const char* const format = "nE,nW,crc6+pos12,nE,nW,crc6";
  const std::string master = folder.path("master.vcd");
  ASSERT_EQ(run({"simulate", "-f", format, "--cycles", "3", "-o", master}).status, 0);
  const std::string truth = folder.path("truth.csv");
  const auto positions_with = [&](const std::vector<std::string>& options) {
    std::vector<std::string> words{
        "simulate", "-f", format, "--ma-from", master, "-o", folder.path("out.vcd"),
        "--truth",  truth};
    words.insert(words.end(), options.begin(), options.end());
    const Outcome made = run(words);
    EXPECT_EQ(made.status, 0) << made.err;
    std::vector<std::string> found;
    for (const Row& row : rows_of(content_of(truth))) found.push_back(row.at("position2"));
    return found;
  };
  const std::string list = folder.file("positions.txt", "5\n4095\n");
  EXPECT_EQ(positions_with({"--positions", list}), (std::vector<std::string>{"5", "4095", "5"}));
  const auto moving = positions_with({"--motion", "ramp"});
  EXPECT_NE(moving.at(0), moving.at(2));
}

TEST(Replay, SampledOutput_HoldsTheSameFrames) {
  const Folder folder;
  const std::string out = folder.path("out.sr");
  ASSERT_EQ(
      run({"simulate", "-f", "resolute-26", "--ma-from", simulated(folder), "-o", out}).status, 0);
  const Outcome decoded = run({"decode", "-f", "resolute-26", out, "--to", "csv"});
  const auto rows = rows_of(decoded.out);
  EXPECT_EQ(rows.size(), 20U);
  for (Row row : rows) EXPECT_EQ(row["status"], "ok");
}

// The moments of all positions, in nanoseconds after the first rising edge of MA.
std::vector<double> moments(const std::string& truth, double lat_ns) {
  std::vector<double> all;
  for (const Row& row : rows_of(truth)) {
    all.push_back(std::stod(row.at("sampled_ns")) - std::stod(row.at("time_ns")) - lat_ns);
  }
  return all;
}

TEST(Truth, MomentsOfTheEncoder_LieBetweenItsBoundsAndRepeat) {
  const Folder folder;
  const std::string capture = folder.path("line.vcd");
  const std::string truth = folder.path("truth.csv");
  const auto simulated = [&](const std::string& seed) {
    EXPECT_EQ(run({"simulate", "-f", "resolute-26", "--clock", "10MHz", "--ma-delay", "20ns",
                   "--seed", seed, "-o", capture, "--truth", truth})
                  .status,
              0);
    return moments(content_of(truth), 70);
  };
  const auto answered = [&](const std::string& seed) {
    EXPECT_EQ(run({"simulate", "-f", "resolute-26", "--ma-from", capture, "--seed", seed, "-o",
                   folder.path("answered.vcd"), "--truth", truth})
                  .status,
              0);
    return moments(content_of(truth), 50);
  };
  const auto check = [&](const auto& moments_with) {
    const std::vector<double> first = moments_with("1");
    ASSERT_EQ(first.size(), 100U);
    const auto [earliest, latest] = std::minmax_element(first.begin(), first.end());
    EXPECT_GE(*earliest, 3224.999);
    EXPECT_LE(*latest, 3275.001);
    EXPECT_GT(*latest - *earliest, 40);
    EXPECT_EQ(moments_with("1"), first);
    EXPECT_NE(moments_with("2"), first);
  };
  check(simulated);
  check(answered);
}

TEST(Replay, WrongUse_IsRefusedAndNothingWritten) {
  const Folder folder;
  const std::string master = simulated(folder);
  const std::string out = folder.path("out.vcd");
  const std::vector<std::vector<std::string>> wrong{
      {"--ma-from", master, "--slo-from", master},
      {"--ma-from", master, "--rate", "1kHz"},
      {"--ma-from", master, "--clock", "1MHz"},
      {"--ma-from", master, "--fault", "flip:0.1"},
      {"--ma-from", master, "--readings", "r.csv"},
      {"--ma-from", master, "--slo", "SLO"},
      {"--slo-from", master, "--truth", "t.csv"},
      {"--slo-from", master, "--cable", "5m"},
      {"--ma-from", master, "--ma", "CLK"},
      {"--slo-from", master, "--ma", "SLO", "--slo", "SLO"}};
  for (const auto& options : wrong) {
    std::vector<std::string> arguments{"simulate", "-f", "resolute-26", "-o", out};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 2) << options[2] << ": " << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(out));
  }
}

TEST(Replay, UnreadableOrSilentCapture_EndsWithItsStatus) {
  const Folder folder;
  const std::string out = folder.path("out.vcd");
  const auto with = [&](const std::string& option, const std::string& file) {
    return run({"simulate", "-f", "resolute-26", option, file, "-o", out});
  };
  EXPECT_EQ(with("--ma-from", folder.path("none.vcd")).status, 3);
  EXPECT_EQ(with("--ma-from", folder.file("broken.csv", "time_ns,MA,SLO\n0,1,1\nx,0,1\n")).status,
            3);
  const std::string silent = folder.file("silent.csv", "time_ns,MA,SLO\n0,1,1\n5,1,0\n9,1,1\n");
  EXPECT_EQ(with("--ma-from", silent).status, 1);
  EXPECT_EQ(with("--slo-from", silent).status, 1);
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(Replay, TimesOfMoreThanTenDays_AreRefused) {
  const Folder folder;
  const std::string out = folder.path("out.vcd");
  for (const char* time : {"-864001", "864001", "9223372"}) {
    const std::string rows = time[0] == '-' ? std::string(time) + ",0,1\n0,1,1\n"
                                            : "0,0,1\n" + std::string(time) + ",1,1\n";
    const std::string file = folder.file("long.csv", "time_s,MA,SLO\n" + rows);
    for (const char* option : {"--ma-from", "--slo-from"}) {
      const Outcome outcome = run({"simulate", "-f", "resolute-26", option, file, "-o", out});
      EXPECT_EQ(outcome.status, 3) << time;
      EXPECT_NE(outcome.err.find("ten days"), std::string::npos) << outcome.err;
      EXPECT_FALSE(std::filesystem::exists(out));
    }
  }
}

}  // namespace replay_test
}  // namespace biss::verbs
