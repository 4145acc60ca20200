// The rows of `decode`: which of them and which columns are written, the columns of motion, and the
// formats HDF5 and VCD.
#include <cmath>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::rows_test {

using testing::HasSubstr;
using testing::StartsWith;

class DecodeRows : public testing::Test {
 protected:
  std::string simulate(const std::string& name, const Words& more) const {
    run_ok(Words{"simulate", "-o", folder.path(name)} + more);
    return folder.path(name);
  }
  // Some of each kind of row.
  std::string with_faults() const {
    return simulate("line.vcd",
                    "-f resolute-26 --cycles 400 --fault flip:0.05 --fault nE:0.05 --fault "
                    "no_answer:0.05 --seed 4");
  }
  static Outcome csv(const std::string& capture, const Words& more,
                     const std::string& format = "resolute-26") {
    return run(Words{"decode", capture, "-f", format, "--to", "csv"} + more);
  }
  static std::string header_of(const Outcome& outcome) {
    return outcome.out.substr(0, outcome.out.find('\n'));
  }

  Folder folder;
};

TEST_F(DecodeRows, FormatWithAnErrorOfTheMakerOrAnotherCode_ReadsTheTruePositions) {
  for (const std::string format :
       {"pos26,nE,nW,crc6:reversed", "pos26,nE,nW,crc6:no-flags", "pos26,nE,nW,crc6:cds",
        "pos26,nE,nW,crc6:previous", "mt12:gray,st13:gray,nE,nW,crc6", "pos26:lsb,nE,nW,crc6",
        "pos26:gray:lsb,nE,nW,crc6", "mt12:lsb,st13,crc6:reversed:cds;cds0",
        "pos24,nE,nW,crc6:previous+pos20,nE,lc6,crc16:previous:reversed"}) {
    const std::string truth = folder.path("truth.csv");
    const std::string capture =
        simulate("line.vcd", Words("-f {} --cycles 60 --motion random --truth {}", format, truth));
    const auto meant = rows_of(content_of(truth));
    for (const Words& how : {Words{}, Words{"--no-compensation"}}) {
      const auto rows = rows_of(csv(capture, how, format).out);
      ASSERT_EQ(rows.size(), 60U) << format;
      const bool previous = format.find(":previous") != std::string::npos;
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (previous && i == 59) {
          EXPECT_EQ(rows[i].at("status"), "unchecked") << format;
          EXPECT_EQ(rows[i].at("position"), "") << format;
          continue;
        }
        ASSERT_EQ(rows[i].at("status"), "ok") << format << ' ' << i;
        ASSERT_EQ(rows[i].at("position"), meant[i].at("position")) << format << ' ' << i;
        ASSERT_EQ(rows[i].at("crc_ok"), "1") << format << ' ' << i;
      }
    }
  }
}

// A wrong bit makes the cycle wrong that it is in, not the next one that has the checksum.
TEST_F(DecodeRows, ChecksumOfTheFrameBefore_NeverPassesAWrongPosition) {
  const std::string format = "pos26,nE,nW,crc16:previous";
  const std::string truth = folder.path("truth.csv");
  const std::string capture = simulate(
      "line.vcd",
      Words("-f {} --cycles 200 --fault flip:0.2 --fault no_answer:0.1 --truth {}", format, truth));
  const auto meant = rows_of(content_of(truth));
  const auto rows = rows_of(csv(capture, {}, format).out);
  ASSERT_EQ(rows.size(), meant.size());
  std::size_t good = 0;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].at("status") == "crc") ++wrong;
    if (rows[i].at("status") != "ok") continue;
    ++good;
    ASSERT_EQ(rows[i].at("position"), meant[i].at("position")) << i;
  }
  EXPECT_GT(good, 80U);
  EXPECT_GT(wrong, 20U);
}

TEST_F(DecodeRows, ChecksumOfTheFrameBefore_IsRefusedWhereAFrameIsAlone) {
  const std::string format = "pos26,nE,nW,crc6:previous";
  for (const Words& words :
       {Words{"crc", "-f", format, "5"}, Words{"crc", "-f", format, "--read", "C0 05"},
        Words{"safety", "analyse", "-f", format},
        Words{"safety", "analyse", "-f", "pos26,nE,nW,crc6:reversed"}}) {
    EXPECT_THAT(run(words), fails(2, StartsWith("biss: -f: ")));
  }
}

TEST_F(DecodeRows, ColumnsThatAreNamed_AreWrittenInTheirOrder) {
  const std::string capture = with_faults();
  const auto all = rows_of(csv(capture, {}).out);
  const Outcome some = csv(capture, "--columns nE,raw,cycle");
  EXPECT_EQ(header_of(some), "nE,raw,cycle");
  const auto rows = rows_of(some.out);
  ASSERT_EQ(rows.size(), all.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const char* name : {"nE", "raw", "cycle"}) EXPECT_EQ(rows[i].at(name), all[i].at(name));
  }
  const Outcome lines =
      run("decode {} -f resolute-26 --to jsonl --columns status --columns cycle", capture);
  EXPECT_THAT(lines.out, StartsWith("{\"status\":\"ok\",\"cycle\":0}\n"));
  EXPECT_EQ(header_of(csv(capture, {capture, "--columns", "cycle,file"})), "cycle,file");
}

TEST_F(DecodeRows, ColumnThatDoesNotExist_IsWrongUsageAndLeavesTheOutput) {
  const std::string capture = with_faults();
  const std::string output = folder.file("old.csv", "old");
  EXPECT_THAT(csv(capture, Words("--columns cycle,posision -o {}", output)),
              fails(2, "--columns: 'posision' is not one of cycle, time_ns, status"));
  EXPECT_EQ(content_of(output), "old");
  EXPECT_THAT(csv(capture, "--columns cycle,nE,cycle"), fails(2, "'cycle' is given twice"));
}

TEST_F(DecodeRows, OnlyErrors_LeavesOutWhatIsGood) {
  const std::string capture = with_faults();
  const Outcome every = csv(capture, {});
  std::vector<Row> wanted;
  for (const Row& row : rows_of(every.out)) {
    const std::string& status = row.at("status");
    const bool cut = status == "cut_start" || status == "cut_end";
    if ((status != "ok" && !cut) || row.at("nE") == "0" || !row.at("limits").empty()) {
      wanted.push_back(row);
    }
  }
  const Outcome errors = csv(capture, {"--only-errors"});
  EXPECT_EQ(rows_of(errors.out), wanted);
  EXPECT_GT(wanted.size(), 30U);
  EXPECT_LT(wanted.size(), 200U);
  EXPECT_EQ(errors.err, every.err) << "the summary counts every row";
  const std::string good = simulate("good.vcd", "-f resolute-26 --cycles 20");
  EXPECT_EQ(rows_of(csv(good, {"--only-errors"}).out).size(), 0U);
}

TEST_F(DecodeRows, OnlyErrors_HasTheFaultsOfTheSafetyMonitor) {
  const std::string capture =
      simulate("line.vcd", "-f fs-36-28 --cycles 200 --fault repeat:0.05 --seed 3");
  const auto rows = rows_of(csv(capture, {"--only-errors"}, "fs-36-28").out);
  ASSERT_FALSE(rows.empty());
  for (const Row& row : rows) {
    EXPECT_TRUE(row.at("status") != "ok" || row.at("safety") != "safe") << row.at("cycle");
  }
}

TEST_F(DecodeRows, Every_IsTheFirstAndEachNthOfTheRowsThatAreLeft) {
  const std::string capture = with_faults();
  const auto all = rows_of(csv(capture, {}).out);
  const auto third = rows_of(csv(capture, "--every 3").out);
  ASSERT_EQ(third.size(), (all.size() + 2) / 3);
  for (std::size_t i = 0; i < third.size(); ++i) EXPECT_EQ(third[i], all[i * 3]);
  const auto errors = rows_of(csv(capture, {"--only-errors"}).out);
  const auto some = rows_of(csv(capture, "--only-errors --every 5").out);
  ASSERT_EQ(some.size(), (errors.size() + 4) / 5);
  for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i], errors[i * 5]);
  EXPECT_EQ(csv(capture, "--every 0").status, 2);
}

TEST_F(DecodeRows, Unwrap_ContinuesThePositionOverTheRollover) {
  // A thousandth of the range in each request: the position rolls over.
  const std::string format = "pos16,nE,nW,crc6";
  const std::string capture = simulate("line.vcd", Words("-f {} --cycles 2000", format));
  const auto rows = rows_of(csv(capture, {"--unwrap"}, format).out);
  ASSERT_EQ(rows.size(), 2000U);
  std::int64_t last = 0;
  bool rolled = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto unwrapped = std::stoll(rows[i].at("unwrapped"));
    EXPECT_EQ(unwrapped & 0xFFFF, std::stoll(rows[i].at("position"))) << i;
    EXPECT_LE(std::abs(unwrapped - last), i == 0 ? 0xFFFF : 100) << i;
    rolled = rolled || unwrapped < 0 || unwrapped > 0xFFFF;
    last = unwrapped;
  }
  EXPECT_TRUE(rolled);
}

TEST_F(DecodeRows, PositionThatMayHaveMovedTooFar_IsNotUnwrappedFromThere) {
  const std::string format = "pos16,nE,nW,crc6";
  const std::string capture =
      simulate("line.vcd", Words("-f {} --cycles 300 --fault no_answer:0.1 --seed 2", format));
  const Outcome outcome = ok(csv(capture, "--unwrap --max-step 32767", format));
  bool lost = false;
  std::string first;
  for (const Row& row : rows_of(outcome.out)) {
    EXPECT_TRUE(!lost || row.at("unwrapped").empty()) << row.at("cycle");
    if (!row.at("position").empty() && row.at("unwrapped").empty() && !lost) {
      lost = true;
      first = row.at("cycle");
    }
  }
  EXPECT_TRUE(lost);
  EXPECT_THAT(outcome.err, HasSubstr("unwrapped is not known from cycle " + first + " on"));
  EXPECT_THAT(csv(capture, "--unwrap --max-step 100", format).err,
              testing::Not(HasSubstr("unwrapped is not known")));
}

TEST_F(DecodeRows, StepsLargerThanMaxStep_AreNamedWithIt) {
  // A thousandth of the range in each request.
  const std::string format = "pos16,nE,nW,crc6";
  const std::string capture = simulate("line.vcd", Words("-f {} --cycles 50", format));
  const Outcome outcome = ok(csv(capture, "--unwrap --velocity --max-step 20", format));
  EXPECT_EQ(rows_of(outcome.out).at(1).at("velocity_counts_s"), "");
  EXPECT_THAT(outcome.err, HasSubstr("unwrapped is not known from cycle 1 on: a step is larger "
                                     "than 20 counts"));
  EXPECT_THAT(outcome.err, HasSubstr("velocity is not known in 49 of its rows: a step is larger "
                                     "than 20 counts"));
  EXPECT_THAT(csv(capture, {"--velocity"}, format).err, testing::Not(HasSubstr("is not known")));
  for (const char* step : {"32768", "70000"}) {
    EXPECT_THAT(csv(capture, {"--unwrap", "--max-step", step}, format),
                fails(2, "is not below half of the range of 16 bits"))
        << step;
  }
}

TEST_F(DecodeRows, PositionAbove63Bits_IsNamedWhereItIsNotUnwrapped) {
  const std::string format = "pos64,crc6";
  const std::string capture =
      simulate("line.vcd", Words("-f {} --cycles 20 --motion max --seed 3", format));
  const Outcome outcome = csv(capture, "--unwrap --max-step 0x7000000000000000", format);
  ASSERT_GT(std::stoull(rows_of(outcome.out).at(0).at("position")), 1ULL << 63U);
  EXPECT_EQ(rows_of(outcome.out).at(0).at("unwrapped"), "");
  EXPECT_THAT(outcome.err,
              HasSubstr("unwrapped is not known from cycle 0 on: 64 bits with a sign"));
}

TEST_F(DecodeRows, Scale_IsThePositionInDegreesOrMillimetres) {
  const std::string capture = simulate("line.vcd", "-f resolute-26 --cycles 20");
  const auto expect = [&](const std::string& scale, const std::string& format,
                          const std::string& column, double per_count) {
    const Outcome outcome = ok(csv(capture, {"--scale", scale}, format));
    for (const Row& row : rows_of(outcome.out)) {
      const double exact = std::stod(row.at("position")) * per_count;
      EXPECT_NEAR(std::stod(row.at(column)), exact, std::abs(exact) * 1e-12);
    }
  };
  expect("deg", "resolute-26", "position_deg", 360.0 / 67108864);
  expect("2^26/turn", "pos26,nE,nW,crc6", "position_deg", 360.0 / 67108864);
  expect("36000/turn", "pos26,nE,nW,crc6", "position_deg", 0.01);
  expect("deg", "mt10,st16,nE,nW,crc6", "position_deg", 360.0 / 65536);
  expect("mm", "fortis-26", "position_mm", 50e-6);
  expect("0.5um", "resolute-26", "position_mm", 0.0005);
}

TEST_F(DecodeRows, ScaleThatIsNotKnown_IsRefusedByName) {
  const std::string capture = simulate("line.vcd", "-f resolute-26 --cycles 20");
  const auto refuse = [&](const std::string& scale, const std::string& format,
                          const std::string& why) {
    EXPECT_THAT(csv(capture, {"--scale", scale}, format), refuses(2, why)) << scale;
  };
  refuse("deg", "pos26,nE,nW,crc6", "--scale deg: the counts of a turn are not known");
  refuse("mm", "pos26,nE,nW,crc6", "--scale mm: the size of a count is not known");
  refuse("mm", "resolute-26", "--scale mm: the size of a count is not known");
  refuse("deg", "fortis-26", "--scale deg: the counts of a turn are not known");
  refuse("deg", "none", "need the format of the frame");
  for (const char* wrong : {"rad", "0/turn", "2^64/turn", "1.5/turn", "-5nm", "nan nm", "50"}) {
    refuse(wrong, "resolute-26", "is none of deg, mm");
  }
  EXPECT_THAT(csv(capture, "--max-step 5"),
              fails(2, "--max-step: only with --unwrap or --velocity"));
}

TEST_F(DecodeRows, Velocity_IsTheStepByTheTimeAlsoOverTheRollover) {
  const std::string format = "pos16,nE,nW,crc6";
  const std::string capture =
      simulate("line.vcd", Words("-f {} --cycles 2000 --fault no_answer:0.01 --seed 2", format));
  const auto rows =
      rows_of(csv(capture,
                  "--velocity --max-step 1500 --columns time_ns,position,velocity_counts_s", format)
                  .out);
  std::size_t last = rows.size();
  std::size_t judged = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].at("position").empty()) {
      EXPECT_EQ(rows[i].at("velocity_counts_s"), "");
      continue;
    }
    const std::string& shown = rows[i].at("velocity_counts_s");
    if (last != rows.size() && !shown.empty()) {
      auto step =
          (std::stoll(rows[i].at("position")) - std::stoll(rows[last].at("position"))) & 0xFFFF;
      if (step >= 0x8000) step -= 0x10000;
      const double seconds =
          (std::stod(rows[i].at("time_ns")) - std::stod(rows[last].at("time_ns"))) * 1e-9;
      const double exact = static_cast<double>(step) / seconds;
      EXPECT_NEAR(std::stod(shown), exact, std::abs(exact) * 1e-6) << i;
      ++judged;
    }
    last = i;
  }
  EXPECT_GT(judged, 1800U);
  const Outcome scaled = csv(capture, "--velocity --scale 2^16/turn", format);
  EXPECT_THAT(header_of(scaled), HasSubstr(",limits,position_deg,velocity_deg_s"));
}

// --since and --until choose rows; what a row says still depends on the cycles before it.
TEST_F(DecodeRows, SinceAndUntil_LeaveTheRowsAsTheyAre) {
  for (const char* format : {"fs-36-28", "mt16,st19,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0"}) {
    SCOPED_TRACE(format);
    const std::string capture = simulate(
        "line.csv", Words("-f {} --cycles 120 --fault flip:0.1 --fault loss@70 --seed 5", format));
    const bool unwraps = std::string_view(format) == "fs-36-28";
    const Words columns = unwraps ? Words{"--unwrap", "--velocity"} : Words{"--velocity"};
    const auto all = rows_of(csv(capture, columns, format).out);
    ASSERT_GE(all.size(), 120U);
    for (const std::size_t first : {1U, 30U, 31U, 71U, 100U}) {
      const std::string since = all[first].at("time_ns") + "ns";
      const std::string until = all[first + 9].at("time_ns") + "ns";
      const auto some =
          rows_of(csv(capture, Words("--since {} --until {}", since, until) + columns, format).out);
      ASSERT_EQ(some.size(), 10U);
      for (std::size_t i = 0; i < some.size(); ++i) EXPECT_EQ(some[i], all[first + i]) << first + i;
    }
  }
}

TEST_F(DecodeRows, SinceAndUntil_CountTheirOwnRowsAlone) {
  const std::string format = "fs-36-28";
  const std::string capture =
      simulate("line.csv", Words("-f {} --cycles 60 --fault loss@20", format));
  const auto all = rows_of(csv(capture, {}, format).out);
  EXPECT_EQ(csv(capture, "--fail-on safety", format).status, 1);
  const Outcome late =
      ok(csv(capture, Words("--since {} --fail-on safety,starting", all[30].at("time_ns") + "ns"),
             format));
  EXPECT_THAT(late.err, testing::ContainsRegex("safety +30 safe "));
  const Outcome early =
      ok(csv(capture, Words("--until {} --fail-on safety", all[10].at("time_ns") + "ns"), format));
  EXPECT_THAT(early.err, testing::ContainsRegex("safety +9 safe, 2 starting "));
  const auto rolls = rows_of(csv(capture, "--columns lc2,time_ns", format).out);
  const auto after = std::find_if(rolls.begin() + 30, rolls.end(),
                                  [](const Row& row) { return row.at("lc2") == "2"; });
  ASSERT_NE(after, rolls.end());
  EXPECT_THAT(csv(capture, {"--since", after->at("time_ns") + "ns"}, format).err,
              HasSubstr("period not seen"));
}

TEST_F(DecodeRows, SinceBehindALostPosition_NamesWhereItWasLost) {
  const std::string format = "pos12,nE,nW,crc6";
  const std::string capture =
      simulate("line.csv", Words("-f {} --cycles 60 --motion random", format));
  const auto all = rows_of(csv(capture, {}, format).out);
  const Outcome late = csv(
      capture, Words("--unwrap --velocity --max-step 1 --since {}", all[50].at("time_ns") + "ns"),
      format);
  EXPECT_THAT(late.err, testing::ContainsRegex("unwrapped is not known from cycle [1-9] on"));
  EXPECT_THAT(late.err, HasSubstr("velocity is not known in 10 of its rows"));
}

TEST_F(DecodeRows, Hdf5_NeedsAFile) {
  const std::string capture = simulate("line.vcd", "-f resolute-26 --cycles 20");
  for (const Words& words : {Words{}, Words{"-o", "-"}, Words{"-o", "/dev/null"}}) {
    EXPECT_THAT(run(Words{"decode", capture, "--to", "hdf5"} + words),
                refuses(2, "--to hdf5: not to a pipe or device; name a file with -o"));
  }
  const std::string output = folder.path("rows.h5");
  run_ok("decode {} --to hdf5 -o {}", capture, output);
  const std::string first = content_of(output);
  EXPECT_THAT(first, StartsWith("MATLAB 7.3 MAT-file"));
  EXPECT_EQ(first.substr(512, 4), "\x89HDF");
  run_ok("decode {} --to hdf5 -o {}", capture, output);
  EXPECT_TRUE(content_of(output) == first) << "the same rows give the same file";
}

TEST_F(DecodeRows, Hdf5_WithoutItsLibraryNamesIt) {
  const std::string capture = simulate("line.vcd", {"-f", "resolute-26", "--cycles", "20"});
  for (const char* name : {"libhdf5_serial.so.103", "libhdf5.so.103"}) {
    std::ofstream(folder.path(name)) << "no library";
  }
  const std::string output = folder.path("rows.h5");
  ::setenv("LD_LIBRARY_PATH", folder.path("").c_str(), 1);
  EXPECT_THAT(run({"decode", capture, "--to", "hdf5", "-o", output}),
              fails(3, testing::ContainsRegex("HDF5: the library libhdf5.*.so.[0-9]+ cannot be "
                                              "loaded")));
  ::unsetenv("LD_LIBRARY_PATH");
  EXPECT_FALSE(std::filesystem::exists(output));
}

TEST_F(DecodeRows, Vcd_ShowsTheTracksAtTheTimesOfTheCapture) {
  const std::string capture = simulate("line.vcd", "-f resolute-26 --cycles 20");
  const auto rows = rows_of(csv(capture, {}).out);
  const std::string output = folder.path("rows.vcd");
  run_ok("decode {} -f resolute-26 --to vcd --columns position,nE,status,frame -o {}", capture,
         output);
  const std::string text = content_of(output);
  EXPECT_THAT(text, HasSubstr("$var integer 27 $ position $end\n$var wire 1 % nE $end\n"
                              "$var string 1 & status $end\n$var string 1 ' frame $end\n"));
  for (const Row& row : rows) {
    const auto picoseconds =
        static_cast<long long>(std::llround(std::stod(row.at("time_ns")) * 1e3));
    EXPECT_THAT(text, HasSubstr(fmt::format("\n#{}\n1\"\n", picoseconds)));
    EXPECT_THAT(text, HasSubstr(fmt::format("b{:b} $\n", std::stoull(row.at("position")))));
    EXPECT_THAT(
        text, HasSubstr(fmt::format("\nspos={}\\040nE=1\\040nW=1\\040crc=0x", row.at("position"))));
  }
  const std::string converted = folder.path("rows.fst");
  EXPECT_EQ(
      std::system(fmt::format("vcd2fst '{}' '{}' > /dev/null 2>&1", output, converted).c_str()), 0);
}

TEST_F(DecodeRows, VcdOfWhatHasNoOneTime_IsRefused) {
  const std::string capture = simulate("line.vcd", "-f resolute-26 --cycles 20");
  EXPECT_THAT(run("decode {} {} --to vcd", capture, capture),
              fails(2, "--to vcd: only for one capture and one pair of lines"));
  const std::string csv_capture = simulate("line.csv", "-f resolute-26 --cycles 20");
  // The same lines, with a pulse of MA before 0.
  std::string early = content_of(csv_capture);
  const std::size_t first = early.find('\n') + 1;
  early.insert(first, "-20000.000,1,1\n-15000.000,0,1\n-14500.000,1,1\n");
  const std::string before = folder.file("early.csv", early);
  const std::string output = folder.file("old.vcd", "old");
  const Words words("decode {} -f resolute-26 --to vcd -o {}", before, output);
  EXPECT_THAT(run(words), fails(2, "the capture begins before 0; give --since 0s"));
  EXPECT_EQ(content_of(output), "old");
  run_ok(words + Words{"--since", "0s"});
}

TEST_F(DecodeRows, FullDisk_LeavesTheOldFile) {
  const std::string capture = simulate("line.sr", "-f resolute-26 --cycles 20000");
  for (const char* to : {"csv", "jsonl", "table", "vcd", "hdf5"}) {
    const std::string output = folder.file("old", "old");
    const Words words("decode {} -f resolute-26 --to {} -o {}", capture, to, output);
    EXPECT_EQ(run_limited("-f 600", words).status, 3) << to;
    EXPECT_EQ(content_of(output), "old") << to;
    run_ok(words);
    EXPECT_NE(content_of(output), "old") << to;
  }
  EXPECT_EQ(folder.files(), 2U);
}

// Removes what runs that were killed while they replaced a file have left, and counts it. Such a
// file has a name only between the last byte and the replacement, so it is complete.
std::size_t remove_left(const Folder& folder, const std::string& whole) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path(""))) {
    if (!entry.path().filename().string().starts_with(".biss-")) continue;
    EXPECT_TRUE(content_of(entry.path().string()) == whole) << entry.path();
    std::filesystem::remove(entry.path());
    ++count;
  }
  return count;
}

TEST_F(DecodeRows, KilledAtAnyMoment_LeavesTheOldFileOrTheWholeNewOne) {
  const std::string capture = simulate("line.sr", "-f resolute-26 --cycles 4000");
  std::size_t killed = 0;
  for (const char* to : {"csv", "hdf5"}) {
    const std::string output = folder.path("rows");
    const Words words("decode {} -f resolute-26 --to {} -o {}", capture, to, output);
    run_ok(words);
    const std::string whole = content_of(output);
    for (int i = 0; i < 50; ++i) {
      folder.file("rows", "old");
      const int status = run_for(std::chrono::microseconds(500 + i * 700), "KILL", words).status;
      const std::string left = content_of(output);
      EXPECT_TRUE(left == "old" || left == whole) << left.size();
      EXPECT_TRUE(status != 0 || left == whole);
      EXPECT_LE(remove_left(folder, whole), status == 0 ? 0U : 1U);
      killed += status == 128 + SIGKILL ? 1U : 0U;
    }
    EXPECT_EQ(folder.files(), 2U);
  }
  EXPECT_GT(killed, 0U);
}

TEST_F(DecodeRows, KilledWithoutAnOldFile_LeavesNothingOrTheWholeFile) {
  const std::string capture = simulate("line.sr", "-f resolute-26 --cycles 4000");
  const std::string output = folder.path("rows");
  const Words words("decode {} -f resolute-26 --to csv -o {}", capture, output);
  run_ok(words);
  const std::string whole = content_of(output);
  for (int i = 0; i < 50; ++i) {
    std::filesystem::remove(output);
    const int status = run_for(std::chrono::microseconds(500 + i * 700), "KILL", words).status;
    const bool there = std::filesystem::exists(output);
    EXPECT_TRUE(status != 0 || there);
    if (there) {
      EXPECT_TRUE(content_of(output) == whole) << i;
    }
    EXPECT_EQ(folder.files(), there ? 2U : 1U) << "a temporary file is left";
  }
}

}  // namespace biss::verbs::rows_test
