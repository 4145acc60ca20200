// `identify`, and `decode` without a format.
#include <nlohmann/json.hpp>

#include "biss/crc/engines.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::identify_verb_test {

using testing::AllOf;
using testing::HasSubstr;

// The last `count` bits of a number as text.
std::string bits_of(std::uint64_t value, unsigned count) {
  std::string bits;
  for (unsigned i = count; i-- > 0;) bits += ((value >> i) & 1U) != 0 ? '1' : '0';
  return bits;
}

// Data and its CRC of 6 bits; of the first `covered` bits only.
std::string frame_of(std::uint64_t data, unsigned count, unsigned uncovered = 0) {
  const CrcBitwise crc(crc6);
  return bits_of(data, count) + bits_of(crc(data >> uncovered, count - uncovered), 6);
}

// Frames on two lines as event CSV: MA of 1 MHz, an ACK of three clocks, a request every 150 us. Each
// text has the bits after CDS; STOP follows.
std::string line_of(const std::vector<std::string>& frames) {
  std::string csv = "time_ns,MA,SLO\n0,1,1\n";
  long begin = 1000;
  for (const std::string& frame : frames) {
    const std::string answer = "00010" + frame + "0";
    int slo = 1;
    const auto put = [&](long time, int ma) {
      csv += std::to_string(time) + ',' + std::to_string(ma) + ',' + std::to_string(slo) + '\n';
    };
    const auto clocks = static_cast<long>(answer.size()) + 1;
    for (long i = 0; i < clocks; ++i) {
      put(begin + 1000 * i, 0);
      put(begin + 1000 * i + 500, 1);
      if (i == 0) continue;
      slo = answer[static_cast<std::size_t>(i - 1)] - '0';
      put(begin + 1000 * i + 600, 1);
    }
    slo = 1;
    put(begin + 1000 * clocks + 15000, 1);
    begin += 150'000;
  }
  return csv;
}

std::uint64_t reversed(std::uint64_t value, unsigned count) {
  std::uint64_t result = 0;
  for (unsigned i = 0; i < count; ++i) result |= ((value >> i) & 1U) << (count - 1 - i);
  return result;
}

class Identify : public testing::Test {
 protected:
  std::string simulated(const std::string& name, const Words& words) const {
    const std::string path = folder_.path(name);
    run_ok(Words("simulate -o {}", path) + words);
    return path;
  }
  // The only row.
  static nlohmann::json identified(const std::string& capture, int status) {
    const Outcome outcome = run("identify {} --to jsonl", capture);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    return nlohmann::json::parse(outcome.out);
  }

  const Folder folder_;
};

TEST_F(Identify, UnknownFormatInMotion_IsFoundWithItsLine) {
  const std::string format = "pos24,nE,nW,lc6,crc9:0x2CF:0x15";
  const std::string capture = simulated(
      "line.vcd",
      Words("-f {} --clock 2MHz --cable 20m --cycles 200 --motion max --timeout static:20us",
            format));
  const nlohmann::json row = identified(capture, 0);
  EXPECT_EQ(row["ma"], "MA");
  EXPECT_EQ(row["slo"], "SLO");
  EXPECT_EQ(row["inverted"], nullptr);
  EXPECT_EQ(row["clock_hz"], 2'000'000);
  EXPECT_EQ(row["format"], format);
  EXPECT_EQ(row["protocol"], "biss_c");
  EXPECT_EQ(row["cycles"], 200);
  // Clock and length of the frames are constant, so that every rule fits.
  EXPECT_EQ(row["timeout"], nullptr);
}

TEST_F(Identify, EncoderOfTheCatalogue_IsSureAndNamed) {
  const nlohmann::json row =
      identified(simulated("line.csv", "-f fs-36-28 --clock 5MHz --cycles 200"), 0);
  EXPECT_EQ(row["format"], "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0");
  EXPECT_GE(row["confidence"], 0.9);
  EXPECT_THAT(row["encoders"].get<std::string>(), HasSubstr("fs-36-28"));
}

TEST_F(Identify, FormatGiven_IsWrongUsage) {
  const std::string capture = simulated("line.csv", "-f resolute-26 --cycles 200");
  EXPECT_THAT(run("identify {} -f resolute-26", capture), fails(2, "leave it out"));
  run_ok("identify {} -f none", capture);
  EXPECT_THAT(run("identify --help").out, HasSubstr("refused here"));
}

TEST_F(Identify, ExampleOfTheDocument_ShowsTheRowOfTheCommand) {
  const std::string document = content_of(BISS_SOURCE_FOLDER "/docs/identify.md");
  ASSERT_NE(document.find("$ biss simulate -f resolute-26 --cycles 200 -o capture.vcd\n"),
            std::string::npos);
  const std::string capture = simulated("capture.vcd", "-f resolute-26 --cycles 200");
  const std::string table = run("identify {}", capture).out;
  const std::size_t row = table.rfind("capture.vcd");
  ASSERT_NE(row, std::string::npos);
  EXPECT_THAT(document, HasSubstr("\n" + table.substr(row))) << table;
}

TEST_F(Identify, DamagedCycles_DoNotSpoilIt) {
  const nlohmann::json row = identified(
      simulated(
          "line.vcd",
          "-f lenz-b3 --cycles 200 --fault flip:0.03 --fault burst:0.03 --fault lost_clock:0.02"),
      0);
  EXPECT_THAT(row["encoders"].get<std::string>(), HasSubstr("lenz-b3"));
}

// A pulse makes CDS 1 in a frame whose checksum is right; no control frame has requested it.
TEST_F(Identify, SingleOneOfCds_DoesNotRuleOutEncodersWithoutRegisters) {
  const std::string capture =
      simulated("line.vcd", "-f pos26,nE,nW,crc6;cds0 --cycles 400 --fault glitch_slo@50,clock=4");
  const auto rows = rows_of(run("decode {} -f pos26,nE,nW,crc6;cds0 --to csv", capture).out);
  ASSERT_EQ(rows.at(50).at("status"), "cds");
  ASSERT_EQ(rows.at(50).at("crc_ok"), "1");
  const nlohmann::json row = identified(capture, 0);
  EXPECT_EQ(row["format"], "pos26,nE,nW,crc6;cds0");
  EXPECT_THAT(row["encoders"].get<std::string>(), HasSubstr("resolute-26"));
}

TEST_F(Identify, EncoderThatAnswersOneAccess_IsNoneWithoutRegisters) {
  std::string bytes;
  for (int i = 0; i < 128; ++i) bytes += "A5 ";
  const std::string capture = simulated(
      "line.vcd", Words("-f pos26,nE,nW,crc6 --cycles 400 --registers {} --access read:0x78,1",
                        folder_.file("registers.hex", bytes)));
  const nlohmann::json row = identified(capture, 0);
  EXPECT_EQ(row["format"].get<std::string>().find("cds0"), std::string::npos) << row["format"];
  EXPECT_EQ(row["encoders"].get<std::string>().find("resolute"), std::string::npos);
}

TEST_F(Identify, PositionAtRest_CannotBeKnown) {
  const std::string capture =
      simulated("line.vcd", "-f resolute-26 --cycles 200 --motion constant");
  EXPECT_EQ(identified(capture, 1)["confidence"], nullptr);
  const Outcome decoded = run("decode {} --to csv", capture);
  EXPECT_THAT(decoded.err, AllOf(HasSubstr("format      not known"), HasSubstr("did not move"),
                                 HasSubstr("200 unchecked")));
  for (const Row& row : rows_of(decoded.out)) EXPECT_EQ(row.at("position"), "");
}

TEST_F(Identify, DecodeWithoutFormat_GivesTheRowsOfTheFormat) {
  const std::string capture =
      simulated("line.sr", "-f resolute-32 --clock 1MHz --cycles 200 --fault flip:0.02");
  const Outcome found = run("decode {} --to csv", capture);
  EXPECT_EQ(found.out, run("decode {} --to csv -f pos32,nE,nW,crc6;cds0", capture).out);
  EXPECT_THAT(found.err,
              AllOf(HasSubstr("identified, confidence 0.9"),
                    HasSubstr("-f \"pos32,nE,nW,crc6;cds0\""), HasSubstr("resolute-32")));
}

TEST_F(Identify, DecodeWithoutFormatFromAPipe_GivesTheSameRows) {
  const std::string capture = simulated("line.vcd", "-f resolute-26 --cycles 200");
  EXPECT_EQ(run({"decode", "-", "--to", "csv"}, capture).out,
            run("decode {} --to csv", capture).out);
}

TEST_F(Identify, FormatNone_ChecksTheStructureOnly) {
  const std::string capture = simulated("line.vcd", "-f resolute-26 --cycles 200");
  const Outcome outcome = run("decode {} --to csv -f none", capture);
  for (const Row& row : rows_of(outcome.out)) EXPECT_EQ(row.at("status"), "unchecked");
}

TEST_F(Identify, TwoCapturesWithDifferentColumns_AreBothRead) {
  const std::string one = simulated("one.vcd", "-f resolute-26 --cycles 200");
  const std::string two = simulated("two.vcd", "-f fs-36-28 --cycles 200");
  const Outcome outcome = run_ok("decode {} {} --to csv", one, two);
  const auto rows = rows_of(outcome.out);
  ASSERT_EQ(rows.size(), 400U);
  EXPECT_EQ(rows[199].at("status"), "ok");
  EXPECT_EQ(rows[200].at("status"), "unchecked");
  EXPECT_EQ(rows[200].at("file"), two);
  EXPECT_THAT(outcome.err, HasSubstr("decode it alone"));
  run_ok("identify {} {} --to csv", one, two);
}

// ---- Flags that are used

TEST_F(Identify, ErrorInThirtyPercentOfTheFrames_IsNoBitOfThePosition) {
  const std::string capture = simulated(
      "line.csv", "-f pos26,nE,nW,crc6 --clock 10MHz --motion ramp --cycles 400 --fault nE:0.3");
  EXPECT_THAT(identified(capture, 0)["format"].get<std::string>(),
              testing::StartsWith("pos26,nE,nW,crc6"));
  const Outcome decoded = run("decode {} --to csv --fail-on nE", capture);
  EXPECT_EQ(decoded.status, 1) << decoded.err;
}

TEST_F(Identify, FlagInABlockOfFrames_IsNoBitOfThePosition) {
  for (const std::string flag : {"nE", "nW"}) {
    Words words("-f pos26,nE,nW,crc6 --clock 10MHz --motion ramp --cycles 400");
    for (int cycle = 150; cycle < 270; ++cycle) {
      words.insert(words.end(), {"--fault", flag + "@" + std::to_string(cycle)});
    }
    EXPECT_THAT(identified(simulated(flag + ".csv", words), 0)["format"].get<std::string>(),
                testing::StartsWith("pos26,nE,nW,crc6"))
        << flag;
  }
}

// Each repeat lets the sign of life stand still and then jump.
TEST_F(Identify, FramesThatComeAgain_HaveTheirSignOfLife) {
  for (const char* seed : {"1", "2", "3"}) {
    const std::string capture =
        simulated("line.csv", Words("-f pos28,nE,nW,lc6,crc16 --clock 8MHz --motion max --cycles "
                                    "356 --fault repeat:0.3 --seed {}",
                                    seed));
    EXPECT_THAT(identified(capture, 0)["format"].get<std::string>(),
                testing::HasSubstr("nE,nW,lc6,crc16"))
        << seed;
  }
}

TEST_F(Identify, FewErrors_AreAmongTheCandidates) {
  const std::string capture = simulated(
      "line.csv", "-f pos26,nE,nW,crc6 --clock 10MHz --motion ramp --cycles 400 --fault nE:0.1");
  EXPECT_THAT(run("identify {} --to jsonl", capture).out,
              HasSubstr("\"format\":\"pos26,nE,nW,crc6"));
}

TEST_F(Identify, WarningInTheLastFrames_IsNotLost) {
  Words words("-f pos19,nE,nW,crc6 --clock 1MHz --motion ramp --cycles 6000");
  for (int cycle = 5990; cycle < 6000; ++cycle) {
    words.insert(words.end(), {"--fault", "nW@" + std::to_string(cycle)});
  }
  const std::string capture = simulated("line.csv", words);
  EXPECT_THAT(run("decode {} --to csv --fail-on nW", capture), fails(1, "10 with nW = 0"));
}

// ---- Positions

TEST_F(Identify, TwoTracksSideBySide_AreNotOneNumber) {
  std::vector<std::string> frames;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const std::uint64_t upper = (4000 + 355 * i) & 0x3FFFU;
    const std::uint64_t lower = (900 + 367 * i) & 0x3FFFU;
    frames.push_back(frame_of((upper << 14U | lower) << 2U | 3U, 30));
  }
  const Outcome outcome = run("identify {} --to jsonl", folder_.file("line.csv", line_of(frames)));
  const auto row = nlohmann::json::parse(outcome.out);
  if (row["format"] != nullptr) {
    EXPECT_EQ(row["format"], "mt14,st14,nE,nW,crc6");
  }
}

TEST_F(Identify, LowestBitFirst_IsNamed) {
  std::vector<std::string> frames;
  for (std::uint64_t i = 0; i < 300; ++i) {
    const std::uint64_t position = (70'000 + 731 * i + i * i / 8) & 0x3FFFFU;
    frames.push_back(frame_of(reversed(position, 18) << 2U | 3U, 20));
  }
  EXPECT_EQ(identified(folder_.file("line.csv", line_of(frames)), 0)["format"],
            "pos18:lsb,nE,nW,crc6");
}

TEST_F(Identify, SlowAxisWithTornFrames_HasTheUsualChecksum) {
  std::vector<std::string> frames;
  for (std::uint64_t i = 0; i < 55; ++i) {
    const std::string frame = frame_of((0x1CA + i / 3 + i * i / 40) << 2U | 3U, 34);
    frames.push_back(i % 6 == 5 ? frame.substr(0, 20 + i / 4) : frame);
  }
  const auto row = nlohmann::json::parse(
      run("identify {} --to jsonl", folder_.file("line.csv", line_of(frames))).out);
  const std::string first = row["format"] != nullptr
                                ? row["format"].get<std::string>()
                                : row["alternatives"][0]["format"].get<std::string>();
  EXPECT_THAT(first, testing::StartsWith("pos32,nE,nW,crc6"));
}

// ---- Lengths that change

TEST_F(Identify, FramesThatChangeTheirLength_HaveAFormatForEachPart) {
  std::vector<std::string> frames;
  for (std::uint64_t i = 0; i < 120; ++i) {
    frames.push_back(frame_of(((1000 + 977 * i) & 0x7FFFFU) << 2U | 3U, 21));
  }
  for (std::uint64_t i = 0; i < 120; ++i) {
    frames.push_back(frame_of(((5000 + 97'703 * i) & 0xFFFFFFFU) << 2U | 3U, 30));
  }
  const std::string capture = folder_.file("line.csv", line_of(frames));
  const Outcome outcome = run_ok("identify {} --to jsonl", capture);
  const auto one = nlohmann::json::parse(outcome.out.substr(0, outcome.out.find('\n')));
  const auto two = nlohmann::json::parse(outcome.out.substr(outcome.out.find('\n') + 1));
  EXPECT_EQ(one["format"], "pos19,nE,nW,crc6");
  EXPECT_EQ(one["from_cycle"], 1) << "cycle 0 is cut";
  EXPECT_EQ(one["to_cycle"], 119) << outcome.err;
  EXPECT_EQ(two["format"], "mt12,st16,nE,nW,crc6");
  EXPECT_EQ(two["from_cycle"], 120);
  EXPECT_EQ(two["to_cycle"], 239);
  EXPECT_THAT(outcome.err, HasSubstr("length"));
  EXPECT_THAT(run("decode {} --to csv", capture).err, HasSubstr("the format changes"));
  const Outcome first = run("identify {} --until 17ms --to jsonl", capture);
  EXPECT_EQ(nlohmann::json::parse(first.out)["format"], "pos19,nE,nW,crc6");
  EXPECT_THAT(run("identify {} --since 10s", capture),
              fails(1, "no request cycle between --since and --until"));
}

TEST_F(Identify, FramesThatChangeTheirLengthInAWholeCapture_HaveAPartThatBeginsWithCycle0) {
  const std::string capture = simulated(
      "line.vcd", "-f pos19,nE,nW,crc6 --then mt12,st16,nE,nW,crc6@120 --cycles 240 --seed 2");
  const Outcome outcome = run("identify {} --to jsonl", capture);
  const auto one = nlohmann::json::parse(outcome.out.substr(0, outcome.out.find('\n')));
  const auto two = nlohmann::json::parse(outcome.out.substr(outcome.out.find('\n') + 1));
  EXPECT_EQ(one["from_cycle"], 0);
  EXPECT_EQ(one["to_cycle"], 119);
  EXPECT_EQ(two["from_cycle"], 120);
  EXPECT_EQ(two["to_cycle"], 239);
}

TEST_F(Identify, FullFramesAmongShortOnes_GiveTheFormat) {
  std::vector<std::string> frames;
  for (std::uint64_t i = 0; i < 400; ++i) {
    const std::string frame = frame_of(((1000 + 977 * i) & 0x7FFFFU) << 2U | 3U, 21);
    frames.push_back(i % 5 == 0 ? frame : frame.substr(0, 1));
  }
  EXPECT_EQ(identified(folder_.file("line.csv", line_of(frames)), 0)["format"], "pos19,nE,nW,crc6");
}

// The beginning of the capture, of which the format is found first, ends before them.
TEST_F(Identify, LaterFramesThatContradict_AreSaidToAndTheRowsAreJudgedByMostFrames) {
  std::vector<std::string> frames;
  for (std::uint64_t i = 0; i < 4500; ++i) {
    frames.push_back(frame_of(((1000 + 977 * i) & 0x7FFFFU) << 2U | 3U, 21));
  }
  for (std::uint64_t i = 0; i < 4600; ++i) {
    frames.push_back(frame_of(((5000 + 97'703 * i) & 0xFFFFFFFU) << 2U | 3U, 30));
  }
  const Outcome outcome = run("decode {} --to csv", folder_.file("line.csv", line_of(frames)));
  const auto rows = rows_of(outcome.out);
  ASSERT_EQ(rows.size(), frames.size());
  EXPECT_NE(rows[10].at("status"), "ok");
  EXPECT_EQ(rows[9000].at("status"), "ok");
  EXPECT_EQ(rows[9000].at("position"), std::to_string((5000 + 97'703 * 4500) & 0xFFFFFFF));
  EXPECT_THAT(outcome.err, AllOf(HasSubstr("the format changes"), HasSubstr("pos19,nE,nW,crc6"),
                                 HasSubstr("mt12,st16,nE,nW,crc6 from cycle 4")));
}

// ---- Errors of an encoder's maker

TEST_F(Identify, ChecksumWithAnErrorOfItsMaker_IsNamed) {
  std::vector<std::string> crc_reversed;
  std::vector<std::string> without_flags;
  std::vector<std::string> of_previous;
  std::string before = "000000";
  for (std::uint64_t i = 0; i < 200; ++i) {
    const std::uint64_t data = ((123'456 + 3331 * i + i * i / 3) & 0x3FFFFFU) << 2U | 3U;
    const std::string frame = frame_of(data, 24);
    std::string crc = frame.substr(24);
    of_previous.push_back(frame.substr(0, 24) + before);
    before = crc;
    std::reverse(crc.begin(), crc.end());
    crc_reversed.push_back(frame.substr(0, 24) + crc);
    without_flags.push_back(frame_of(data, 24, 2));
  }
  EXPECT_EQ(identified(folder_.file("a.csv", line_of(crc_reversed)), 0)["format"],
            "pos22,nE,nW,crc6:reversed");
  EXPECT_EQ(identified(folder_.file("b.csv", line_of(without_flags)), 0)["format"],
            "pos22,nE,nW,crc6:no-flags");
  EXPECT_EQ(identified(folder_.file("c.csv", line_of(of_previous)), 0)["format"],
            "pos22,nE,nW,crc6:previous");
}

// ---- What scripts rely on

TEST_F(Identify, FormatThatIsNotSure_IsNullAndItsGuessesHaveOdds) {
  const std::string capture =
      simulated("line.csv", "-f pos26,nE,nW,crc6 --cycles 30 --motion constant");
  const nlohmann::json row = identified(capture, 1);
  EXPECT_EQ(row["format"], nullptr);
  ASSERT_FALSE(row["alternatives"].empty());
  double last = 1;
  for (const auto& each : row["alternatives"]) {
    EXPECT_TRUE(each["format"].is_string());
    EXPECT_LE(each["odds"].get<double>(), last);
    last = each["odds"];
  }
  EXPECT_THAT(run("identify {} --to csv", capture).out, HasSubstr(" | "));
}

TEST_F(Identify, LineThatIsNoBissC_IsNamed) {
  // 9600 Bd, 8N1, "biss identify" again and again on one line; the other one is idle.
  std::string csv = "time_us,A,B\n0,1,1\n";
  double time = 1000;
  int level = 1;
  for (int i = 0; i < 40; ++i) {
    for (const char c : std::string("biss identify\r\n")) {
      const int frame = (c << 1) | 0x200;
      for (int bit = 0; bit < 10; ++bit) {
        const int next = (frame >> bit) & 1;
        if (next != level) csv += std::to_string(time) + ',' + std::to_string(next) + ",1\n";
        level = next;
        time += 1e6 / 9600;
      }
    }
    time += 5000;
  }
  const std::string capture = folder_.file("text.csv", csv);
  const nlohmann::json row = identified(capture, 1);
  EXPECT_EQ(row["protocol"], "uart");
  EXPECT_EQ(row["format"], nullptr);
}

}  // namespace biss::verbs::identify_verb_test
