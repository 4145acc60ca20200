// `biss simulate --ma-from` and `--slo-from`: recorded masters with a simulated encoder, recorded
// encoders with a simulated master.
#include "tests/cli/reference_captures.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::replay_test {

using Replay = InFolder;

class RecordedCaptures : public testing::TestWithParam<std::string> {};

TEST_P(RecordedCaptures, EveryCompleteRequest_IsAnsweredWithAFrame) {
  for (const ReferenceCapture& capture : reference_captures()) {
    SCOPED_TRACE(capture.path);
    const Folder folder;
    const std::string answered = folder.path("answered.vcd");
    const std::string truth_path = folder.path("truth.csv");
    run_ok("simulate -f {} --cable 20m --ma-from {} -o {} --truth {}", capture.format,
           capture.path + GetParam(), answered, truth_path);
    const auto rows = rows_of(run_ok("decode -f {} {} --to csv", capture.format, answered).out);
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
    run_ok("simulate -f {} --slo-from {} -o {} --readings {}", capture.format,
           capture.path + GetParam(), folder.path("line.vcd"), readings);
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
  run_ok("simulate -f resolute-26 --clock 2MHz --cycles 20 -o {}", path);
  return path;
}

TEST_F(Replay, CaptureOfMaAlone_IsAnswered) {
  const std::string master =
      folder.file("ma.csv", "time_ns,clk\n0,1\n10000,0\n10500,1\n11000,0\n11500,1\n12000,0\n");
  const Outcome outcome =
      run_ok("simulate -f pos12,crc6 --ma-from {} -o {}", master, folder.path("out.csv"));
  EXPECT_THAT(outcome.err,
              testing::HasSubstr("1 requests, 0 answered up to STOP, 1 cut by the master"));
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

TEST_F(Replay, MasterThatWaitsForStart_IsNamedAndTheHintHelps) {
  const std::string out = folder.path("out.csv");
  const std::string master = folder.file("ma.csv", waiting_master({}));
  const Words arguments("simulate -f pos12,crc6 --ma-from {} -o {}", master, out);
  const Outcome first = run_ok(arguments);
  EXPECT_THAT(first.err,
              testing::HasSubstr("3 requests, 0 answered up to STOP, 3 cut by the master"));
  EXPECT_THAT(first.err,
              testing::HasSubstr("If it waits for START, feed it the SLO of '" + out + "'"));
  folder.file("ma.csv", waiting_master(slo_edges(out)));
  const Outcome second = run(arguments);
  EXPECT_THAT(second.err, testing::HasSubstr("3 requests, 3 answered up to STOP"));
  EXPECT_EQ(second.err.find("waits for START"), std::string::npos) << second.err;
}

TEST_F(Replay, Rerun_RunsTheMasterUntilEveryRequestIsAnswered) {
  const std::string out = folder.path("out.csv");
  const std::string master = folder.file("ma.csv", waiting_master({}));
  const Words arguments("simulate -f pos12,crc6 --ma-from {} -o {}", master, out);
  run_ok(arguments);
  const std::string again = folder.file("again.csv", waiting_master(slo_edges(out)));

  const auto with = [&](const std::string& command) {
    return run(arguments + Words{"--rerun", command});
  };
  const Outcome outcome = ok(with("cp '" + again + "' '" + master + "'"));
  EXPECT_THAT(outcome.err, testing::HasSubstr("3 requests, 3 answered up to STOP"));
  run_ok("decode -f pos12,crc6 {}", out);

  folder.file("ma.csv", waiting_master({}));
  EXPECT_THAT(with("true"), fails(1, "the master still ends requests before STOP"));
  EXPECT_THAT(with("exit 7"), fails(3, "--rerun: the command failed: 'exit 7'"));
}

TEST_F(Replay, Positions_AreSentInTurn) {
  const std::string master = simulated(folder);
  const std::string truth = folder.path("truth.csv");
  const auto with = [&](const std::string& list) {
    return run("simulate -f resolute-26 --ma-from {} --positions {} -o {} --truth {}", master,
               folder.file("positions.txt", list), folder.path("out.vcd"), truth);
  };
  ok(with("# corners\n0\n0x3FFFFFF # the last one\n\n4711\n"));
  const auto rows = rows_of(content_of(truth));
  ASSERT_EQ(rows.size(), 20U);
  const std::vector<std::string> sent{"0", "67108863", "4711"};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i].at("position"), sent[i % sent.size()]) << i;
  }
  const auto decoded =
      rows_of(run("decode -f resolute-26 {} --to csv", folder.path("out.vcd")).out);
  ASSERT_EQ(decoded.size(), 20U);
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    EXPECT_EQ(decoded[i].at("position"), sent[i % sent.size()]) << i;
  }
  EXPECT_EQ(with("0\n67108864\n").status, 3);
  EXPECT_NE(with("0\n67108864\n").err.find("line 2: '67108864'"), std::string::npos);
  EXPECT_NE(with("# nothing\n").err.find("no position"), std::string::npos);
}

TEST_F(Replay, EncoderThatIsNotReady_IsNamedInSummaryAndTruth) {
  const std::string truth = folder.path("truth.csv");
  const Outcome outcome =
      run_ok("simulate -f resolute-26 --timeout cycle:1ms --ma-from {} -o {} --truth {}",
             simulated(folder), folder.path("out.vcd"), truth);
  EXPECT_THAT(outcome.err, testing::HasSubstr("19 before the encoder was ready"));
  auto rows = rows_of(content_of(truth));
  ASSERT_EQ(rows.size(), 20U);
  EXPECT_EQ(rows[0]["faults"], "");
  EXPECT_EQ(rows[1]["faults"], "not_ready");
  EXPECT_EQ(rows[1]["position"], "");
}

TEST_F(Replay, AnotherClockThanTheRecordedOne_ReadsNoFrame) {
  const std::string readings = folder.path("readings.csv");
  run_ok("simulate -f resolute-26 --clock 3MHz --slo-from {} -o {} --readings {}",
         simulated(folder), folder.path("out.vcd"), readings);
  const auto rows = rows_of(content_of(readings));
  ASSERT_EQ(rows.size(), 20U);
  for (Row row : rows) {
    EXPECT_NE(row["status"], "ok");
    EXPECT_EQ(row["position"], "");
    EXPECT_EQ(row["crc_ok"], row["status"] == "crc" ? "0" : "");
  }
}

TEST_F(Replay, FirstChannelWithoutAPosition_LeavesThatOfTheSecondOne) {
  const char* const format = "nE,nW,crc6+pos12,nE,nW,crc6";
  const std::string master = folder.path("master.vcd");
  run_ok("simulate -f {} --cycles 3 -o {}", format, master);
  const std::string truth = folder.path("truth.csv");
  const auto positions_with = [&](const Words& options) {
    run_ok(Words("simulate -f {} --ma-from {} -o {} --truth {}", format, master,
                 folder.path("out.vcd"), truth) +
           options);
    std::vector<std::string> found;
    for (const Row& row : rows_of(content_of(truth))) found.push_back(row.at("position2"));
    return found;
  };
  const std::string list = folder.file("positions.txt", "5\n4095\n");
  EXPECT_EQ(positions_with({"--positions", list}), (std::vector<std::string>{"5", "4095", "5"}));
  const auto moving = positions_with({"--motion", "ramp"});
  EXPECT_NE(moving.at(0), moving.at(2));
}

TEST_F(Replay, SampledOutput_HoldsTheSameFrames) {
  const std::string out = folder.path("out.sr");
  run_ok("simulate -f resolute-26 --ma-from {} -o {}", simulated(folder), out);
  const Outcome decoded = run("decode -f resolute-26 {} --to csv", out);
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
    run_ok("simulate -f resolute-26 --clock 10MHz --ma-delay 20ns --seed {} -o {} --truth {}", seed,
           capture, truth);
    return moments(content_of(truth), 70);
  };
  const auto answered = [&](const std::string& seed) {
    run_ok("simulate -f resolute-26 --ma-from {} --seed {} -o {} --truth {}", capture, seed,
           folder.path("answered.vcd"), truth);
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

TEST_F(Replay, WrongUse_IsRefusedAndNothingWritten) {
  const std::string master = simulated(folder);
  const std::string out = folder.path("out.vcd");
  const std::vector<Words> wrong{{"--ma-from", master, "--slo-from", master},
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
    const Outcome outcome = run(Words("simulate -f resolute-26 -o {}", out) + options);
    EXPECT_EQ(outcome.status, 2) << options[2] << ": " << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(out));
  }
}

TEST_F(Replay, UnreadableOrSilentCapture_EndsWithItsStatus) {
  const std::string out = folder.path("out.vcd");
  const auto with = [&](const std::string& option, const std::string& file) {
    return run("simulate -f resolute-26 {} {} -o {}", option, file, out);
  };
  EXPECT_EQ(with("--ma-from", folder.path("none.vcd")).status, 3);
  EXPECT_EQ(with("--ma-from", folder.file("broken.csv", "time_ns,MA,SLO\n0,1,1\nx,0,1\n")).status,
            3);
  const std::string silent = folder.file("silent.csv", "time_ns,MA,SLO\n0,1,1\n5,1,0\n9,1,1\n");
  EXPECT_EQ(with("--ma-from", silent).status, 1);
  EXPECT_EQ(with("--slo-from", silent).status, 1);
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(Replay, TimesOfMoreThanTenDays_AreRefused) {
  const std::string out = folder.path("out.vcd");
  for (const char* time : {"-864001", "864001", "9223372"}) {
    const std::string rows = time[0] == '-' ? std::string(time) + ",0,1\n0,1,1\n"
                                            : "0,0,1\n" + std::string(time) + ",1,1\n";
    const std::string file = folder.file("long.csv", "time_s,MA,SLO\n" + rows);
    for (const char* option : {"--ma-from", "--slo-from"}) {
      EXPECT_THAT(run("simulate -f resolute-26 {} {} -o {}", option, file, out),
                  fails(3, "ten days"))
          << time;
      EXPECT_FALSE(std::filesystem::exists(out));
    }
  }
}

}  // namespace biss::verbs::replay_test
