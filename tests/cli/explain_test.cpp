// `biss explain`: causes with the figures of the capture, and a cycle drawn bit by bit.
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::explain_test {

using ExplainVerb = InFolder;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* format = "pos26,nE,nW,crc6";

std::string simulate(const Folder& folder, const Words& more = {}) {
  const std::string capture = folder.path("line.csv");
  run_ok(Words("simulate -f {} --clock 1MHz --cable 20m --seed 3 -o {} --cycles 200", format,
               capture) +
         more);
  return capture;
}

std::vector<json> rows_in(const std::string& text) {
  std::vector<json> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) rows.push_back(json::parse(line));
  return rows;
}

std::string text_in(const json& row, const char* key) { return row.at(key).get<std::string>(); }

std::vector<json> explain(const Words& words, const std::string& input = "/dev/null") {
  return rows_in(run_ok(Words("explain -f {} --to jsonl", format) + words, input).out);
}

std::vector<json> explained(const std::string& capture, const std::string& of,
                            const Words& more = {}) {
  Words words("explain {} --to jsonl", capture);
  if (!of.empty()) words = words + Words{"-f", of};
  return rows_in(run_ok(words + more).out);
}

// The pause after this clock of a frame, in nanoseconds; counted from 0.
using Pause = std::function<std::int64_t(int frame, int clock)>;

std::int64_t no_pause(int, int) { return 0; }

// `frames` requests of `clocks` clocks of 1 µs to an encoder that needs 20 µs. The pause after the last
// clock of a request is `rest`.
std::string answered(
    const Folder& folder, const std::string& of, int frames, int clocks, const Pause& pause,
    const Words& more = {}, const Pause& rest = [](int, int) { return 80'000; }) {
  std::string ma = "time_ns,MA\n0,1\n";
  std::int64_t now = 50'000;
  for (int frame = 0; frame < frames; ++frame) {
    for (int clock = 0; clock < clocks; ++clock) {
      ma += fmt::format("{},0\n{},1\n", now, now + 500);
      now += 1000 + (clock + 1 < clocks ? pause : rest)(frame, clock);
    }
  }
  const std::string capture = folder.path("answered.csv");
  run_ok(Words("simulate -f {} --ma-from {} --timeout static:20us -o {}", of,
               folder.file("ma.csv", ma), capture) +
         more);
  return capture;
}

// 60 requests of `clocks`; every fifth one is followed by `pause`, in nanoseconds.
std::string requests_of(const Folder& folder, int clocks, std::int64_t pause) {
  return answered(folder, format, 60, clocks, no_pause, {},
                  [&](int request, int) { return request % 5 == 4 ? pause : 40'000; });
}

TEST_F(ExplainVerb, CleanCapture_IsHealthy) {
  const auto rows = explain({simulate(folder)});
  ASSERT_FALSE(rows.empty());
  EXPECT_EQ(rows[0].at("cause"), "healthy");
  EXPECT_GT(rows[0].at("likelihood").get<double>(), 0.9);
  EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("200 of 200 cycles are good"));
}

TEST_F(ExplainVerb, FormatNotKnown_IsNotCalledHealthyAndAsksForTheFormat) {
  const std::string capture = simulate(folder, "--motion constant --fault flip:0.3");
  const Outcome rows = run("explain {} --to jsonl", capture);
  const json first = rows_in(rows.out).at(0);
  EXPECT_EQ(first.at("cause"), "healthy");
  EXPECT_LE(first.at("likelihood").get<double>(), 0.5);
  EXPECT_THAT(text_in(first, "remedy"), HasSubstr("give -f FORMAT"));
  EXPECT_THAT(text_in(first, "evidence"), Not(HasSubstr("good")));
  const Outcome text = run("explain {}", capture);
  EXPECT_THAT(text.out, HasSubstr("format  not known"));
  EXPECT_THAT(text.out, HasSubstr("200 unchecked"));
  EXPECT_THAT(run("explain {} -f {}", capture, format).out, HasSubstr(format));
  EXPECT_THAT(run("check {}", capture).err, HasSubstr("not known"));
  EXPECT_THAT(run("check {} -f {}", capture, format).err, HasSubstr(format));
  EXPECT_THAT(run("check {} -f none", capture).err, HasSubstr("only the structure"));
}

TEST_F(ExplainVerb, EveryRequestEndsTheSameBitsEarly_IsOneNumber) {
  const auto rows = explain({requests_of(folder, 34, 40'000)});
  EXPECT_EQ(rows.at(0).at("cause"), "master_stops_early");
  EXPECT_THAT(text_in(rows.at(0), "evidence"),
              AllOf(HasSubstr("4 bits are missing"), Not(HasSubstr("4 to 4"))));
}

TEST_F(ExplainVerb, CycleOfEveryEncoder_HasColumnsWithDifferentNames) {
  const Outcome outcome =
      run("explain {} -f {} --cycle 5 --each --to csv", simulate(folder), format);
  const std::string head = outcome.out.substr(0, outcome.out.find('\n'));
  EXPECT_EQ(head,
            "cycle,bit,time_ns,ma,slo,sample,field,clock,expected,mends,status,ma_line,slo_line");
}

TEST_F(ExplainVerb, FlippedBits_AreNoiseWithTheirCyclesAndARemedy) {
  const std::string capture = simulate(
      folder, "--fault flip@20 --fault flip@21 --fault flip@90 --fault flip@91 --fault flip@150");
  const auto rows = explain({capture});
  EXPECT_EQ(rows.at(0).at("cause"), "noise_on_slo");
  EXPECT_THAT(text_in(rows[0], "evidence"),
              HasSubstr("5 of 200 cycles: the checksum is wrong (cycles 20 to 150"));
  EXPECT_THAT(text_in(rows[0], "remedy"), HasSubstr("shield"));
  for (const json& row : rows) EXPECT_EQ(row.size(), 4U);
  // The same from a pipe.
  EXPECT_EQ(explain({"-"}, capture), rows);
}

TEST_F(ExplainVerb, Cycle_IsDrawnWithTheFlipThatMendsIt) {
  const std::string capture = simulate(folder, "--fault flip@20,bit=7");
  const Outcome drawn = run_ok("explain {} -f {} --cycle 20", capture, format);
  EXPECT_THAT(drawn.out, HasSubstr("cycle 20 at "));
  EXPECT_THAT(drawn.out, HasSubstr("START  CDS  pos25"));
  EXPECT_THAT(drawn.out, HasSubstr("pos18 (bit 7)"));
  EXPECT_THAT(drawn.out, HasSubstr("expected"));
  std::vector<std::uint64_t> mending;
  std::string received;
  for (const json& row : explain({capture, "--cycle", "20"})) {
    EXPECT_EQ(row.at("cycle"), 20);
    EXPECT_EQ(row.at("status"), "crc");
    if (row.at("bit").is_null()) continue;
    if (row.at("mends") == 1) mending.push_back(row.at("bit").get<std::uint64_t>());
    if (row.at("field").get<std::string>().starts_with("pos")) {
      received += row.at("slo") == 1 ? '1' : '0';
    }
  }
  EXPECT_THAT(mending, testing::Contains(7U));
  EXPECT_EQ(received.size(), 26U);
  // The next cycle is complete.
  EXPECT_THAT(run("explain {} -f {} --cycle 21", capture, format).out, HasSubstr(": right\n"));
}

TEST_F(ExplainVerb, CycleThatTheCaptureDoesNotHave_IsNamed) {
  EXPECT_THAT(run("explain {} -f {} --cycle 200", simulate(folder), format),
              fails(1, "no cycle 200; the capture has 200 request cycles"));
}

TEST_F(ExplainVerb, LinesExchanged_AreNamed) {
  const auto rows = explain({simulate(folder), "--ma", "SLO", "--slo", "MA"});
  EXPECT_EQ(rows.at(0).at("cause"), "ma_slo_swapped");
  EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("200 of 200"));
}

TEST_F(ExplainVerb, InvertedSlo_IsNamedUnlessTheUserSaysIt) {
  const std::string capture = rewritten(folder, "inverted.csv", simulate(folder), [](Row& row) {
    row["SLO"] = row["SLO"] == "0" ? "1" : "0";
  });
  EXPECT_EQ(explain({capture}).at(0).at("cause"), "slo_inverted");
  EXPECT_EQ(explain({capture, "--invert-slo"}).at(0).at("cause"), "healthy");
}

TEST_F(ExplainVerb, WrongFormat_IsNamed) {
  const std::string capture = simulate(folder, "--motion random");
  const Outcome outcome = run("explain {} -f pos25,nE,nW,crc6 --to jsonl", capture);
  EXPECT_EQ(rows_in(outcome.out).at(0).at("cause"), "wrong_format");
}

// The capture of an encoder of another format, or with these faults.
std::string simulate_as(const Folder& folder, const std::string& of, const Words& more) {
  const std::string capture = folder.path("other.csv");
  Words words("simulate -f {} --cycles 200 -o {}", of, capture);
  if (std::find(more.begin(), more.end(), "--motion") == more.end()) {
    words = words + Words("--motion max");
  }
  run_ok(words + more);
  return capture;
}

TEST_F(ExplainVerb, FaultsOfALine_AreNamedWithTheirEvidence) {
  const std::string counted = "pos26,nE,nW,lc6,crc16";
  const std::string unchecked = "pos22,nE,nW,crc6";
  const std::string usual = "--clock 1MHz --cable 20m --seed 3 --motion ramp --fault ";
  const std::string clocks = "--clock 2.5MHz --motion ramp --processing 10us --fault ";
  struct Case {
    std::string format;
    std::string options;
    std::string given;
    std::string cause;  // a regular expression
    std::string evidence = "";
  };
  for (
      const Case& each : {
          Case{counted, "--fault loss:0.05", counted, "frames_lost_or_repeated",
               "the sign of life"},
          Case{counted, "--fault repeat:0.05", counted, "frames_lost_or_repeated",
               "the sign of life"},
          Case{counted, "--fault lc_frozen:0.05", counted, "frames_lost_or_repeated",
               "the sign of life"},
          Case{unchecked + ":reversed", "--motion ramp --fault nW:0.3", unchecked,
               "wrong_checksum"},
          Case{unchecked + ":no-flags", "--motion ramp --fault nW:0.3", unchecked,
               "wrong_checksum"},
          Case{unchecked + ":previous", "--motion ramp --fault nW:0.3", unchecked,
               "wrong_checksum"},
          Case{unchecked + ":plain", "--motion ramp --fault nW:0.3", unchecked, "wrong_checksum"},
          Case{unchecked + ":0x43:0x15", "--motion ramp --fault nW:0.3", unchecked,
               "wrong_checksum"},
          // MA stays as it is for longer than a request: requests are missing, which no master does.
          Case{format, usual + "ma_low:0.03", format, "supply_or_intermittent|noise_on_ma"},
          Case{format, usual + "ma_high:0.03", format, "supply_or_intermittent|noise_on_ma"},
          // The position of a moving axis is the one that is due, once the clock is put back.
          Case{format, clocks + "extra_clock:0.03", format, "noise_on_ma"},
          Case{format, clocks + "lost_clock:0.03", format, "noise_on_ma"},
          Case{format, clocks + "double_clock:0.03", format, "noise_on_ma"},
          // The master sends the clocks of the line delay after STOP.
          Case{format, "--clock 2.5MHz --cable 60m --processing 10us --fault short_frame:0.1",
               format, "healthy"},
          Case{format, usual + "slo_low:1", format, "stuck_low"},
          Case{format, "--clock 10MHz --internal-delay 66ns", format, "healthy"},
          Case{format, "--clock 10MHz --internal-delay 70ns", format, "healthy"},
          Case{format, "--clock 10MHz --internal-delay 73ns", format, "healthy"},
      }) {
    const auto rows =
        explained(simulate_as(folder, each.format, Words(each.options.c_str())), each.given);
    EXPECT_THAT(text_in(rows.at(0), "cause"), testing::MatchesRegex(each.cause)) << each.options;
    EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr(each.evidence)) << each.options;
  }
}

TEST_F(ExplainVerb, StopIsABitOfAFurtherChannel_IsAWrongFormatAndNoWrongChecksum) {
  const auto rows = explain({simulate_as(folder, "pos26,nE,nW,crc6+pos12,nE,nW,crc6", {})});
  EXPECT_EQ(rows.at(0).at("cause"), "wrong_format") << rows[0];
  for (const json& row : rows) {
    EXPECT_THAT(text_in(row, "evidence"), Not(HasSubstr("checksum is wrong"))) << row;
  }
  EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("STOP is 1 after right"));
}

// The first bit of the second channel is 0 in all frames, as STOP is.
TEST_F(ExplainVerb, FurtherChannelThatBeginsWith0_IsAWrongFormat) {
  std::string positions;
  for (int i = 0; i < 100; ++i) positions += fmt::format("{}\n", 100'000 + 7 * i);
  const auto rows =
      explained(answered(folder, "pos26,nE,nW,crc6+pos20,nE,nW,crc6", 100, 72, no_pause,
                         {"--positions", folder.file("positions.txt", positions)}),
                "pos26,nE,nW,crc6");
  EXPECT_EQ(rows.at(0).at("cause"), "wrong_format") << rows[0];
}

TEST_F(ExplainVerb, EncoderThatSeesMaInverted_IsNamedByTheStopItDoesNotSend) {
  const std::string capture = simulate_as(folder, format, "--fault swap_ma:1 --motion random");
  EXPECT_EQ(explained(capture, "").at(0).at("cause"), "ma_inverted");
  const auto rows = explain({capture});
  EXPECT_EQ(rows.at(0).at("cause"), "ma_inverted") << rows[0];
  EXPECT_THAT(text_in(rows[0], "evidence"),
              AllOf(HasSubstr("STOP is 1 after right checksums"), HasSubstr("misses the last"),
                    HasSubstr("0.50 periods")));
}

TEST_F(ExplainVerb, AckBeyondItsLimitWithoutAFormat_IsNoWrongChecksum) {
  const Outcome outcome =
      run("explain {} -f none --ack-max 5us --to jsonl", simulate(folder, "--processing 9us"));
  ASSERT_FALSE(outcome.out.empty()) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("START is outside"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("checksum is wrong")));
}

// The master sees SLO low and stops after two clocks: no answer is read.
TEST_F(ExplainVerb, SloInvertedAtTheEncoder_IsNamedByTheLevelsThatAreSeen) {
  const auto rows = explain({simulate(folder, "--fault swap_slo:1")});
  EXPECT_EQ(rows.at(0).at("cause"), "slo_inverted");
  EXPECT_THAT(text_in(rows[0], "evidence"),
              AllOf(HasSubstr("SLO rests low and goes high with ACK"), Not(HasSubstr("good"))));
}

// Positions that jump about fall by nearly a power of two now and then: no turns are late.
TEST_F(ExplainVerb, PositionsThatJump_AreHealthy) {
  const std::string capture = folder.path("jumps.csv");
  for (const char* seed : {"1", "2", "3", "4", "5", "6", "7", "8"}) {
    run_ok("simulate -f pos26,nE,nW,crc6 --clock 2MHz --motion random --cycles 300 --seed {} -o {}",
           seed, capture);
    const Outcome outcome = run("explain {} -f pos26,nE,nW,crc6 --to jsonl", capture);
    EXPECT_THAT(outcome.out, testing::StartsWith(R"({"cause":"healthy")")) << seed << outcome.err;
  }
}

TEST_F(ExplainVerb, Warning_IsNamedBesideTheHealthyLink) {
  const auto rows = explain({simulate(folder, "--fault nW:0.05")});
  EXPECT_EQ(rows.at(0).at("cause"), "healthy");
  EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("a warning (nW = 0) (cycles "));
  EXPECT_THAT(text_in(rows[0], "remedy"),
              AllOf(HasSubstr("warning"), Not(HasSubstr("nothing to do"))));
}

TEST_F(ExplainVerb, RequestsTooSoon_AreNamedAsInTheHintOfDecode) {
  const std::string capture = requests_of(folder, 39, 7'000);
  const auto rows = explain({capture});
  EXPECT_EQ(rows.at(0).at("cause"), "requested_too_soon") << rows.at(0);
  const Outcome decoded = run("decode {} -f {} --to csv", capture, format);
  EXPECT_THAT(decoded.err, HasSubstr(text_in(rows[0], "remedy"))) << decoded.err;
  EXPECT_THAT(decoded.err, Not(HasSubstr("which interface")));
}

// ---- Lines of other people, made again from their description

TEST_F(ExplainVerb, ReversedChecksum_IsNamedWithTheFormatThatReadsIt) {
  const auto capture = simulate_as(folder, "pos22,nE,nW,crc6:reversed", "--motion ramp");
  for (const char* given : {"pos22,nE,nW,crc6", ""}) {
    const auto rows = explained(capture, given);
    ASSERT_EQ(rows.at(0).at("cause"), "wrong_checksum") << rows[0];
    EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("its bits are in reverse order"));
    EXPECT_THAT(text_in(rows[0], "remedy"), HasSubstr("pos22,nE,nW,crc6:reversed"));
  }
}

TEST_F(ExplainVerb, PausesOfTheMaster_AreNamed) {
  struct Pauses {
    std::string given;
    int frames;
    int clocks;
    Pause pause;
    Words simulated = {};
    Words explained = {};
  };
  const auto after_each = [](int clocks, int pause) {
    return [=](int, int clock) { return clock % clocks == clocks - 1 ? pause : 0; };
  };
  // The number of clocks is not always the same, so that the parts do not add up to requests.
  const Pause many_lengths = [](int, int clock) {
    return clock == 39 ? 80'000 : clock % 8 == 7 ? 6000 : 0;
  };
  const Words timeout("--timeout static:20us");
  for (const Pauses& each :
       {Pauses{"pos18,nE,nW,crc6", 60, 32, after_each(8, 1000), {}, timeout},
        // Without a format and a timeout, the first bytes alone read as requests of another
        // protocol.
        Pauses{"", 60, 48, after_each(8, 2000)}, Pauses{"", 60, 48, after_each(16, 2000)},
        // With a long ACK, the parts read better where SLO is taken for inverted.
        Pauses{"", 60, 88, many_lengths, "--processing 0ns"},
        Pauses{"", 60, 88, many_lengths, "--processing 12us"},
        Pauses{"", 60, 88, many_lengths, "--processing 25us"},
        // The encoder gives up.
        Pauses{"pos18,nE,nW,crc6", 120, 32,
               [](int frame, int clock) { return frame % 4 == 1 && clock == 22 ? 30'000 : 0; }},
        Pauses{"pos18,nE,nW,crc6",
               120,
               32,
               [](int frame, int clock) { return frame % 10 == 3 && clock == 13 ? 8000 : 0; },
               {},
               timeout}}) {
    const auto rows = explained(
        answered(folder, "pos18,nE,nW,crc6", each.frames, each.clocks, each.pause, each.simulated),
        each.given, each.explained);
    ASSERT_EQ(rows.at(0).at("cause"), "master_pauses_clock") << each.clocks << rows[0];
    for (const char* board : {"Arduino", "Teensy", "ESP32", "STM32"}) {
      EXPECT_THAT(text_in(rows[0], "remedy"), HasSubstr(board));
    }
  }
}

TEST_F(ExplainVerb, LengthOfTheFrameChanges_IsNamed) {
  const std::string first =
      folder.file("first.csv", content_of(answered(folder, "pos19,nE,nW,crc6", 100, 33, no_pause)));
  const std::string second = answered(folder, "pos28,nE,nW,crc6", 100, 42, no_pause);
  const auto rows = explained(joined(folder, first, second), "pos19,nE,nW,crc6");
  ASSERT_EQ(rows.at(0).at("cause"), "format_changes") << rows[0];
  EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("cycles 100 to"));
}

TEST_F(ExplainVerb, TurnsThatFollowTheZeroLate_AreImplausible) {
  std::string positions;
  for (int i = 0; i < 400; ++i) {
    const int position = 7 * 8192 + 7902 + 10 * i;
    const int turns = (position - 37) / 8192;
    positions += fmt::format("{}\n", turns * 8192 + position % 8192);
  }
  const auto rows = explained(answered(folder, "mt12,st13,nE,nW,crc6", 400, 39, no_pause,
                                       {"--positions", folder.file("positions.txt", positions)}),
                              "mt12,st13,nE,nW,crc6");
  ASSERT_EQ(rows.at(0).at("cause"), "position_implausible") << rows[0];
  EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("one turn for up to 4 frames"));
}

// The same turns and singleturn, read as one position: it falls back by a turn, and jumps ahead.
TEST_F(ExplainVerb, TurnsThatFollowLateWithoutAFormat_AreImplausible) {
  std::string positions;
  for (const int late : {1, 3}) {
    positions.clear();
    for (int i = 0; i < 200; ++i) {
      const int position = 7 * 8192 + 7902 + 410 * i;
      const int turns = (position - late * 410) / 8192;
      positions += fmt::format("{}\n", turns * 8192 + position % 8192);
    }
    const std::string capture = answered(folder, "pos25,nE,nW,crc6", 200, 39, no_pause,
                                         {"--positions", folder.file("positions.txt", positions)});
    // The turns of the last format are not those of the encoder.
    for (const char* of : {"pos25,nE,nW,crc6", "mt9,st16,nE,nW,crc6"}) {
      const auto rows = explained(capture, of);
      EXPECT_EQ(rows.at(0).at("cause"), "position_implausible") << of << late << rows[0];
    }
  }
  // A rotary encoder of 13 bits in a field of 25 falls back as well, and does not jump ahead.
  positions.clear();
  for (int i = 0; i < 200; ++i) positions += fmt::format("{}\n", 410 * i % 8192);
  const auto whole = explained(answered(folder, "pos25,nE,nW,crc6", 200, 39, no_pause,
                                        {"--positions", folder.file("positions.txt", positions)}),
                               "pos25,nE,nW,crc6");
  EXPECT_EQ(whole.at(0).at("cause"), "healthy") << whole[0];
}

// A position of turns and singleturn that one damaged frame in twenty lets jump by many turns.
TEST_F(ExplainVerb, JumpOfManyTurns_IsImplausible) {
  std::string positions;
  for (int i = 0; i < 200; ++i) {
    const int turns = i % 20 == 7 ? 900 : 7;
    positions += fmt::format("{}\n", turns * 8192 + 100 + 10 * i);
  }
  const auto rows = explained(answered(folder, "mt12,st13,nE,nW,crc6", 200, 39, no_pause,
                                       {"--positions", folder.file("positions.txt", positions)}),
                              "mt12,st13,nE,nW,crc6");
  EXPECT_EQ(rows.at(0).at("cause"), "position_implausible") << rows[0];
}

TEST_F(ExplainVerb, LimitBesideAnotherCause_IsNamedAsTheSecond) {
  const auto rows = explained(
      simulate_as(folder, "resolute-26", "--clock 1MHz --duty 30% --fault nE:0.3"), "resolute-26");
  ASSERT_GE(rows.size(), 2U) << rows.at(0);
  EXPECT_EQ(rows[0].at("cause"), "encoder_error") << rows[0];
  EXPECT_EQ(rows[1].at("cause"), "limits_exceeded") << rows[1];
}

TEST_F(ExplainVerb, LimitThatCheckFails_IsNotHealthy) {
  struct Case {
    Words simulate;
    std::string format;
    std::string rule;
  };
  for (const Case& each :
       {Case{{"--clock", "10500kHz", "--clock-max", "12MHz"}, "pos26,nE,nW,crc6", "clock_max"},
        Case{{"--clock", "1MHz", "--processing", "17us"}, "resolute-26", "ack_longest"},
        Case{{"--clock", "240kHz"}, "resolute-26", "clock_min"},
        Case{{"--clock", "1MHz", "--duty", "30%"}, "resolute-26", "duty"}}) {
    const std::string capture = simulate_as(folder, "pos26,nE,nW,crc6", each.simulate);
    const auto rows = explained(capture, each.format);
    EXPECT_EQ(rows.at(0).at("cause"), "limits_exceeded") << each.rule << rows[0];
    EXPECT_THAT(text_in(rows[0], "evidence"), HasSubstr("biss check fails " + each.rule));
    EXPECT_EQ(run("check {} -f {}", capture, each.format).status, 1) << each.rule;
  }
}

TEST_F(ExplainVerb, SignOfLifeThatCountsFrom0_NamesTheOption) {
  const std::string counted = "pos26,nE,nW,lc6,crc16";
  const auto rows = explained(simulate_as(folder, counted, "--counter count_0_63"), counted);
  ASSERT_GE(rows.size(), 2U);
  EXPECT_EQ(rows[1].at("cause"), "frames_lost_or_repeated") << rows[1];
  for (const json& row : {rows[0], rows[1]}) {
    EXPECT_THAT(text_in(row, "remedy"), HasSubstr("--counter count_0_63"));
  }
  const auto usual = explained(simulate_as(folder, counted, {}), counted);
  EXPECT_EQ(text_in(usual.at(0), "remedy"), "nothing to do");
}

TEST_F(ExplainVerb, FlagsOfAnEncoderWithoutRegisters_AdviseWhatApplies) {
  const auto errors =
      explained(simulate_as(folder, "resolute-26", "--fault nE:0.1"), "resolute-26");
  EXPECT_EQ(errors.at(0).at("cause"), "encoder_error");
  EXPECT_THAT(text_in(errors[0], "remedy"),
              AllOf(HasSubstr("temperature"), HasSubstr("if it has registers")));
  const auto warnings =
      explained(simulate_as(folder, "resolute-26", "--fault nW:0.1"), "resolute-26");
  EXPECT_THAT(text_in(warnings.at(0), "remedy"),
              AllOf(HasSubstr("clean the scale"), Not(HasSubstr("register"))));
}

TEST_F(ExplainVerb, ShortFramesOfControlCommunication_AreNoEarlyStop) {
  for (const int clocks : {2, 5}) {
    std::string ma = "time_ns,MA\n0,1\n";
    std::int64_t now = 50'000;
    for (int frame = 0; frame < 200; ++frame) {
      for (int clock = 0; clock < (frame % 50 < 25 ? 40 : clocks); ++clock) {
        ma += fmt::format("{},0\n{},1\n", now, now + 500);
        now += 1000;
      }
      now += 80'000;
    }
    const std::string capture = folder.path("short.csv");
    run_ok("simulate -f {} --ma-from {} --timeout static:20us --ack-clocks 1 --positions {} -o {}",
           format, folder.file("ma.csv", ma), folder.file("positions.txt", "5\n"), capture);
    EXPECT_NE(explain({capture}).at(0).at("cause"), "master_stops_early") << clocks;
  }
}

// Bytes on two lines, one after the other: a row a bit, or a row a change.
std::string uart_capture(bool changes) {
  std::string text = "time_ns,D0,D1\n0,1,1\n";
  unsigned last = 1;
  std::uint32_t random = 7;
  std::int64_t now = 100'000;
  for (int byte = 0; byte < 300; ++byte) {
    random = random * 1'664'525U + 1'013'904'223U;
    const unsigned bits = (((random >> 16U) & 0xFFU) << 1U) | 0x200U;
    for (unsigned bit = 0; bit < 10; ++bit) {
      const unsigned level = (bits >> bit) & 1U;
      if (!changes || level != last) {
        text += byte % 2 == 0 ? fmt::format("{},{},1\n", now, level)
                              : fmt::format("{},1,{}\n", now, level);
      }
      last = level;
      now += 8'680;
    }
    now += 200'000;
  }
  return text;
}

// Where no lines look like MA and SLO, decode refuses; explain says what that means.
TEST_F(ExplainVerb, LinesOfAUart_AreNotBiss) {
  const Outcome outcome =
      run("explain {} -f {} --to jsonl", folder.file("uart.csv", uart_capture(true)), format);
  ASSERT_FALSE(outcome.out.empty()) << outcome.err;
  EXPECT_EQ(rows_in(outcome.out).at(0).at("cause"), "not_biss") << outcome.out;
}

// The rows have a constant step and holes, in which the levels are unknown: no cycle can be judged.
TEST_F(ExplainVerb, LineWithoutACycleToJudge_IsNotHealthy) {
  EXPECT_THAT(run("explain {} -f {}", folder.file("uart.csv", uart_capture(false)), format).out,
              Not(HasSubstr("healthy")));
}

TEST_F(ExplainVerb, FileThatEndsInTheMiddle_ExplainsThePartBefore) {
  const std::string whole = content_of(simulate(folder));
  const Outcome outcome =
      run("explain {} -f {}", folder.file("cut.vcd", whole.substr(0, whole.size() / 2)), format);
  EXPECT_THAT(outcome, fails(3, "ends in the middle"));
  EXPECT_THAT(outcome.out, HasSubstr("1. healthy"));
}

TEST_F(ExplainVerb, CaptureWithoutARequest_Fails) {
  const Outcome outcome =
      run("explain {}", folder.file("idle.csv", "time_ns,MA,SLO\n0,1,1\n1000,1,0\n2000,1,1\n"));
  EXPECT_THAT(outcome, fails(1, "no request cycle"));
  // A line at rest is not another protocol.
  EXPECT_THAT(outcome.out, Not(HasSubstr("not_biss")));
}

TEST(ExplainRange, FaultOutsideOfSince_IsNotExplained) {
  const Folder folder;
  const std::string capture = simulate_as(folder, "fs-36-28", "--clock 5MHz --fault flip@3,bit=12");
  const Words words("explain {} -f fs-36-28 --since 1ms --latch", capture);
  const Outcome later = run(words);
  EXPECT_THAT(later.out, HasSubstr("1. healthy")) << later.err;
  EXPECT_THAT(later.out, HasSubstr("safety")) << later.err;
  EXPECT_THAT(later.out, Not(HasSubstr("200 request cycles")));
  const Outcome after = run("explain {} -f fs-36-28 --since 100s", capture);
  EXPECT_THAT(after, fails(1, "no request cycle between --since and --until"));
  EXPECT_THAT(after.out, Not(HasSubstr("1. ")));
}

}  // namespace biss::verbs::explain_test
