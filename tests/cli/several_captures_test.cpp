// Several captures, and several encoders in one capture: lines of different encoders are not
// paired.
#include "tests/cli/run_command.hpp"

namespace biss::verbs::several_captures_test {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const std::string plain_format = "pos26,nE,nW,crc6";

using Positions = std::vector<std::string>;

class SeveralCaptures : public testing::Test {
 protected:
  // An encoder with positions that differ from those of every other seed.
  std::string simulated(const std::string& name, int seed) const {
    const std::string path = folder_.path(name);
    run_ok("simulate -f {} --clock 1MHz --cycles 6 --motion random --seed {} -o {}", plain_format,
           std::to_string(seed), path);
    return path;
  }

  // Joins two event CSVs into one with these lines.
  std::string together(const std::string& name, const std::string& lines, const std::string& first,
                       const std::string& second) const {
    std::vector<std::pair<double, std::string>> rows;
    for (const bool is_first : {true, false}) {
      for (const Row& row : rows_of(content_of(is_first ? first : second))) {
        const std::string levels = row.at("MA") + ',' + row.at("SLO");
        rows.emplace_back(std::stod(row.at("time_ns")),
                          row.at("time_ns") + (is_first ? ',' + levels + ",," : ",,," + levels));
      }
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::string text = "time_ns," + lines + '\n';
    for (const auto& row : rows) text += row.second + '\n';
    return folder_.file(name, text);
  }

  // One line of a capture as a separate one.
  std::string one_line(const std::string& name, const std::string& line,
                       const std::string& capture) const {
    return verbs::one_line(folder_, name, line, capture, line);
  }

  static Outcome decode(const Words& arguments) {
    return run(Words("decode -f {} --to csv", plain_format) + arguments);
  }

  static Positions positions_of(const Outcome& outcome, const std::string& column = "",
                                const std::string& value = "") {
    Positions positions;
    for (const Row& row : rows_of(outcome.out)) {
      if (column.empty() || row.at(column) == value) positions.push_back(row.at("position"));
    }
    return positions;
  }

  Folder folder_;
  std::string a_ = simulated("a.csv", 3);
  std::string b_ = simulated("b.csv", 77);
  Positions of_a_ = positions_of(decode({a_}));
  Positions of_b_ = positions_of(decode({b_}));
};

TEST_F(SeveralCaptures, TwoOfOneType_AreDecodedOneAfterTheOther) {
  ASSERT_EQ(of_a_.size(), 6U);
  ASSERT_NE(of_a_, of_b_);
  const Outcome both = ok(decode({a_, b_}));
  EXPECT_EQ(rows_of(both.out).size(), 12U);
  EXPECT_EQ(positions_of(both, "file", a_), of_a_);
  EXPECT_EQ(positions_of(both, "file", b_), of_b_);
  EXPECT_THAT(both.out, HasSubstr(",marginal,safety,limits,file\n"));
  EXPECT_EQ(rows_of(both.out).at(6).at("cycle"), "0");
  EXPECT_THAT(both.err, AllOf(HasSubstr(a_ + ": 6 request cycles"), HasSubstr(b_ + ": 6 request")));
  EXPECT_THAT(decode({a_}).out, Not(HasSubstr("file")));
}

TEST_F(SeveralCaptures, FilesWithOneLineEach_AreOneCapture) {
  const std::string ma = one_line("ma.csv", "MA", a_);
  const std::string slo = one_line("slo.csv", "SLO", a_);
  const Outcome joined = ok(decode({slo, ma}));
  EXPECT_EQ(positions_of(joined), of_a_);
  EXPECT_THAT(joined.err, HasSubstr("MA = " + ma + ":MA, SLO = " + slo + ":SLO"));
  EXPECT_THAT(joined.out, Not(HasSubstr("file")));
}

TEST_F(SeveralCaptures, MaOfOneFile_DoesNotTakeTheSloOfAnother) {
  const Outcome one = ok(decode({b_, a_, "--ma", a_ + ":MA"}));
  EXPECT_EQ(positions_of(one, "file", a_), of_a_);
  EXPECT_EQ(positions_of(one, "file", b_), of_b_);
}

TEST_F(SeveralCaptures, BothLinesNamed_JoinTheirFiles) {
  // Both requests begin at the same moment, so that MA of one reads SLO of the other.
  const Outcome joined = ok(decode({a_, b_, "--ma", a_ + ":MA", "--slo", b_ + ":SLO"}));
  EXPECT_THAT(joined.err, HasSubstr("MA = " + a_ + ":MA, SLO = " + b_ + ":SLO"));
  const std::string third = simulated("c.csv", 5);
  EXPECT_THAT(decode({a_, b_, third, "--ma", a_ + ":MA", "--slo", b_ + ":SLO"}),
              fails(2, third + ": neither --ma nor --slo names a line of it"));
  EXPECT_THAT(decode({a_, b_, "--ma", third + ":MA"}), fails(2, "is not among the captures given"));
}

TEST_F(SeveralCaptures, ACaptureThatContinuesAnother_IsDecodedToo) {
  const std::string whole = content_of(a_);
  const std::size_t half = whole.find('\n', whole.size() / 2) + 1;
  const std::string begin = folder_.file("begin.csv", whole.substr(0, half));
  const std::string end = folder_.file("end.csv", "time_ns,MA,SLO\n" + whole.substr(half));
  Positions positions = positions_of(decode({begin, end}));
  std::erase(positions, "");
  EXPECT_GE(positions.size(), 5U);
  EXPECT_EQ(positions.back(), of_a_.back());
  EXPECT_EQ(positions.front(), of_a_.front());
}

TEST_F(SeveralCaptures, OneThatCannotBeUsed_DoesNotHideTheOthers) {
  const std::string still = folder_.file("still.csv", "time_ns,MA,SLO\n0,1,1\n9000,1,1\n");
  const Outcome some = decode({still, a_});
  EXPECT_EQ(some.status, 1);
  EXPECT_EQ(positions_of(some, "file", a_), of_a_);
  EXPECT_THAT(some.err, HasSubstr(still + ": no request cycle found"));
  const std::string rows = folder_.file("rows.csv", "old");
  EXPECT_EQ(decode({a_, folder_.path("missing.csv"), "-o", rows}).status, 3);
  EXPECT_EQ(content_of(rows), "old");
  EXPECT_EQ(decode({a_, b_, "-o", b_}).status, 2);
}

TEST_F(SeveralCaptures, OneThatIsDamaged_NamesWhatIsNotRead) {
  const std::string damaged = folder_.file("damaged.csv", content_of(a_) + "1,?\n");
  const Outcome piped = decode({damaged, b_, a_});
  EXPECT_EQ(piped.status, 3);
  EXPECT_EQ(positions_of(piped), of_a_);
  EXPECT_THAT(piped.err, HasSubstr("not read  " + b_ + " and 1 more  "));
  EXPECT_THAT(piped.err, Not(HasSubstr("not written")));
  const std::string rows = folder_.file("rows.csv", "old");
  const Outcome kept = decode({a_, damaged, b_, "-o", rows});
  EXPECT_EQ(kept.status, 3);
  EXPECT_EQ(content_of(rows), "old");
  EXPECT_THAT(kept.err, AllOf(HasSubstr("not written  " + rows), HasSubstr("convert --partial"),
                              HasSubstr("not read     " + b_ + "  ")));
  EXPECT_THAT(decode({a_, damaged}).err, Not(HasSubstr("not read")));
}

class SeveralEncoders : public SeveralCaptures, public testing::WithParamInterface<const char*> {};

TEST_P(SeveralEncoders, InOneCapture_AreRefusedWithTheCandidatesOrReadOneByOne) {
  const std::string lines = GetParam();
  std::istringstream list(lines);
  std::vector<std::string> names;
  for (std::string name; std::getline(list, name, ',');) names.push_back(name);
  const std::string capture = together("both.csv", lines, a_, b_);

  const Outcome tie = decode({capture});
  EXPECT_EQ(tie.status, 1);
  EXPECT_EQ(tie.out, "");
  EXPECT_THAT(tie.err, AllOf(HasSubstr(names[0] + " with " + names[1] + ", " + names[2] + " with " +
                                       names[3]),
                             HasSubstr("--each")));

  const Outcome one = ok(decode({capture, "--ma", names[2]}));
  EXPECT_EQ(positions_of(one), of_b_);
  EXPECT_THAT(one.err, HasSubstr("MA = " + names[2] + ", SLO = " + names[3]));

  const Outcome each = ok(decode({capture, "--each"}));
  EXPECT_EQ(positions_of(each, "slo", names[1]), of_a_);
  EXPECT_EQ(positions_of(each, "slo", names[3]), of_b_);
  EXPECT_THAT(each.out, HasSubstr(",safety,limits,ma,slo\n"));

  for (const char* verb : {"registers", "check"}) {
    EXPECT_THAT(run("{} {} -f {}", verb, capture, plain_format),
                fails(1, "several lines can be MA and SLO"))
        << verb;
  }
  const std::string made = folder_.path("made.vcd");
  EXPECT_THAT(run("simulate -f {} --slo-from {} -o {}", plain_format, capture, made),
              fails(1, AllOf(HasSubstr(names[0]), Not(HasSubstr("--each")))));
}

// The clocks of both are the same, so the data does not say which MA belongs to which SLO.
TEST_F(SeveralCaptures, FourFilesOfTwoEncoders_AreReadOnlyIfTheirPairsAreNamed) {
  Words files;
  for (const auto& [name, capture] : {std::pair{"a", a_}, std::pair{"b", b_}}) {
    files.push_back(one_line(std::string("ma_") + name + ".csv", "MA", capture));
    files.push_back(one_line(std::string("slo_") + name + ".csv", "SLO", capture));
  }
  for (const bool each : {false, true}) {
    auto arguments = files;
    if (each) arguments.emplace_back("--each");
    EXPECT_THAT(decode(arguments),
                fails(1, AllOf(HasSubstr("several lines can be MA and SLO"),
                               HasSubstr("give only its files"), Not(HasSubstr("--each")))));
  }
  EXPECT_EQ(positions_of(
                decode({files[2], files[3], "--ma", files[2] + ":MA", "--slo", files[3] + ":SLO"})),
            of_b_);
}

INSTANTIATE_TEST_SUITE_P(Names, SeveralEncoders,
                         testing::Values("MA1,SLO1,MA2,SLO2", "enc1.MA,enc1.SLO,enc2.MA,enc2.SLO",
                                         "x_MA,x_SLO,y_MA,y_SLO", "MA_A,SLO_A,MA_B,SLO_B"));

TEST_F(SeveralCaptures, EncodersWithoutUsefulNames_AreRefusedWithTheirCandidates) {
  const std::string capture = together("both.csv", "D0,D1,D2,D3", a_, b_);
  EXPECT_THAT(decode({capture}), fails(1, AllOf(HasSubstr("D0 with D1"), HasSubstr("D2 with D3"))));
  EXPECT_EQ(positions_of(decode({capture, "--ma", "D2", "--slo", "D3"})), of_b_);
}

TEST_F(SeveralCaptures, ReplayOfMa_IsRefusedWhereTwoLinesAreMa) {
  const std::string capture = together("both.csv", "a.MA,a.SLO,b.MA,b.SLO", a_, b_);
  const std::string made = folder_.path("made.vcd");
  EXPECT_THAT(run("simulate -f {} --ma-from {} -o {}", plain_format, capture, made),
              fails(1, "a.MA, b.MA"));
  run_ok("simulate -f {} --ma-from {} --ma b.MA -o {}", plain_format, capture, made);
}

TEST_F(SeveralCaptures, RegistersAndConform_SayWhichFile) {
  const Outcome registers = run_ok("registers {} {} --to csv", a_, b_);
  EXPECT_THAT(registers.out, HasSubstr(",busy_ns,file\n"));
  EXPECT_THAT(registers.err, AllOf(HasSubstr(a_), HasSubstr(b_)));
  const Outcome check = run("check {} {} -f {} --to csv", a_, b_, plain_format);
  EXPECT_THAT(check.out, AllOf(HasSubstr(",note,file\n"), HasSubstr(',' + a_ + '\n'),
                               HasSubstr(',' + b_ + '\n')));
  const Outcome dump = run("registers {} {} --dump {}", a_, b_, folder_.path("x.hex"));
  EXPECT_EQ(dump.status, 2);
}

TEST_F(SeveralCaptures, SafetyMonitorOfOneCapture_DoesNotJudgeTheNext) {
  const std::string safe = folder_.path("safe.vcd");
  const std::string plain = folder_.path("plain.vcd");
  for (const auto& [path, format] :
       {std::pair{safe, "fs-36-28"}, std::pair{plain, "resolute-26"}}) {
    run_ok("simulate -f {} --cycles 300 --motion random -o {}", format, path);
  }
  for (const bool safe_first : {true, false}) {
    SCOPED_TRACE(safe_first);
    const Words files = safe_first ? std::vector{safe, plain} : std::vector{plain, safe};
    const Outcome both = run_ok("decode {} {} --to csv", files[0], files[1]);
    std::size_t judged = 0;
    for (const Row& row : rows_of(both.out)) {
      if (row.at("file") == plain) {
        ASSERT_EQ(row.at("safety"), "") << row.at("cycle");
      } else {
        judged += row.at("safety").empty() ? 0U : 1U;
      }
    }
    EXPECT_EQ(judged, safe_first ? 300U : 0U);
    EXPECT_EQ(both.err.find("watchdog "), safe_first ? both.err.rfind("watchdog ") : both.err.npos);
    const Outcome errors = run("decode {} {} --only-errors --to csv", files[0], files[1]);
    EXPECT_EQ(rows_of(errors.out).size(), 0U) << errors.out.substr(0, 500);
  }
}

TEST_F(SeveralCaptures, SafetyMonitor_BeginsAgainWithEachCapture) {
  const std::string path = folder_.path("safe.csv");
  run_ok("simulate -f fs-36-28 --cycles 20 -o {}", path);
  const Outcome twice = run("decode {} {} -f fs-36-28 --latch --to csv", path, path);
  const auto rows = rows_of(twice.out);
  ASSERT_EQ(rows.size(), 40U) << twice.err;
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(rows[i].at("safety"), i < 2 ? "starting" : "safe");
    EXPECT_EQ(rows[20 + i].at("safety"), rows[i].at("safety"));
  }
}

}  // namespace biss::verbs::several_captures_test
