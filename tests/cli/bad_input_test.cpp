// Bad input of every kind: one clear line, the right exit status, bounded memory, no partial file.
#include <sys/wait.h>

#include <cstring>
#include <random>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::bad_input_test {

using BadInput = InFolder;

constexpr const char* usual = "pos26,nE,nW,crc6";

constexpr bool sanitized() {
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  return true;
#endif
#endif
  return false;
}

// An error of one line that names the program. With a summary before it, the last line.
void expect_error(const Outcome& outcome, int status, const std::string& part) {
  EXPECT_EQ(outcome.status, status) << outcome.err.substr(0, 500);
  const std::size_t last = outcome.err.rfind("biss: ");
  ASSERT_NE(last, std::string::npos) << outcome.err;
  const std::string line = outcome.err.substr(last);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << outcome.err;
  EXPECT_TRUE(line.ends_with("\n"));
  EXPECT_THAT(line, testing::HasSubstr(part));
  EXPECT_EQ(outcome.err.find("biss: "), last) << "more than one error: " << outcome.err;
}

// The same, without output.
void expect_usage(const Outcome& outcome, const std::string& part) {
  expect_error(outcome, 2, part);
  EXPECT_EQ(outcome.out, "");
}

std::string good_capture(const Folder& folder, const std::string& extension) {
  const std::string path = folder.path("good" + extension);
  run_ok("simulate -f {} --cycles 30 -o {}", usual, path);
  return content_of(path);
}

// Decodes into a file that must stay unchanged.
void expect_refused(const Folder& folder, const std::string& input, int status,
                    const std::string& part) {
  SCOPED_TRACE(input);
  const std::string output = folder.file("rows.csv", "old rows\n");
  const std::size_t files = folder.files();
  const Outcome outcome = run("decode {} -f {} --to csv -o {}", input, usual, output);
  expect_error(outcome, status, part);
  EXPECT_EQ(content_of(output), "old rows\n");
  EXPECT_EQ(folder.files(), files) << "a temporary file was left";
  EXPECT_EQ(outcome.out, "");
}

TEST_F(BadInput, WhatIsNoCapture_IsRefused) {
  expect_refused(folder, folder.path("missing.vcd"), 3, "cannot be opened");
  expect_refused(folder, folder.path(""), 3, "folder");
  expect_refused(folder, folder.file("empty.vcd", ""), 3, "empty");
  expect_refused(folder, folder.file("empty.csv", " \n\n"), 3, "empty");
  expect_refused(folder, folder.file("text.vcd", "Dear colleague,\nthe encoder is broken.\n"), 3,
                 "text.vcd:1");
  expect_refused(folder, folder.file("noname", "Dear colleague,\n"), 3, "");
  constexpr unsigned seed = 11;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  std::string noise;
  for (int i = 0; i < 100'000; ++i) noise += static_cast<char>(random());
  for (const char* name : {"noise.vcd", "noise.csv", "noise"}) {
    expect_refused(folder, folder.file(name, noise), 3, "");
  }
}

TEST_F(BadInput, TimeThatRunsBackwards_IsNamedWithItsPlace) {
  expect_refused(folder, folder.file("back.csv", "time_ns,MA,SLO\n0,1,1\n100,0,1\n50,1,1\n"), 3,
                 "back.csv:4");
  const std::string vcd = good_capture(folder, ".vcd");
  expect_refused(folder, folder.file("back.vcd", vcd + "#5\n0!\n"), 3, "back.vcd:");
}

TEST_F(BadInput, HalfAFile_GivesWhatIsWholeOrAnErrorNeverAWrongRow) {
  for (const char* extension : {".vcd", ".csv"}) {
    const std::string text = good_capture(folder, extension);
    const auto whole = rows_of(
        run("decode {} -f {} --to csv", folder.path(std::string("good") + extension), usual).out);
    ASSERT_EQ(whole.size(), 30U);
    for (std::size_t cut = 10; cut < text.size(); cut += text.size() / 23) {
      SCOPED_TRACE(std::string(extension) + " cut at " + std::to_string(cut));
      const std::string half = folder.file(std::string("half") + extension, text.substr(0, cut));
      const Outcome outcome = run("decode {} -f {} --to csv", half, usual);
      EXPECT_TRUE(outcome.status == 0 || outcome.status == 1 || outcome.status == 3);
      const auto rows = rows_of(outcome.out);
      for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].at("status") == "ok") {
          EXPECT_EQ(rows[i].at("position"), whole[i].at("position"));
        } else {
          EXPECT_EQ(rows[i].at("status"), "cut_end");
          EXPECT_EQ(i + 1, rows.size());
        }
      }
    }
  }
}

TEST_F(BadInput, ReadErrorBehindGoodRows_PipesThemAndFails) {
  const std::string capture =
      folder.file("tail.vcd", good_capture(folder, ".vcd") + "#99999999999999\nnonsense\n");
  expect_refused(folder, capture, 3, "tail.vcd:");
  const Outcome piped = run("decode {} -f {} --to csv", capture, usual);
  EXPECT_EQ(piped.status, 3);
  EXPECT_EQ(rows_of(piped.out).size(), 30U);
}

TEST_F(BadInput, UnknownLevels_AreRowsOfTheirOwn) {
  std::string text = good_capture(folder, ".csv");
  auto line = text.begin();
  for (int i = 0; i < 400; ++i) line = std::find(line, text.end(), '\n') + 1;
  const auto comma = std::find(line, text.end(), ',');
  *(comma + 1) = 'x';
  *(comma + 3) = 'z';
  const Outcome outcome = run_ok("decode {} -f {} --to csv", folder.file("x.csv", text), usual);
  std::size_t unknown = 0;
  std::size_t good = 0;
  for (const Row& row : rows_of(outcome.out)) {
    unknown += row.at("status") == "unknown_level" ? 1U : 0U;
    good += row.at("status") == "ok" ? 1U : 0U;
  }
  EXPECT_EQ(unknown, 1U);
  EXPECT_EQ(good, 29U);
}

TEST_F(BadInput, LinesThatAreNotThere_AreWrongUsage) {
  good_capture(folder, ".csv");
  const std::string capture = folder.path("good.csv");
  for (const Words& options :
       {Words("--ma CLK"), Words("--slo other.csv:SLO"), Words("--ma SLO --slo SLO")}) {
    expect_usage(run(Words("decode {}", capture) + options), "");
  }
}

TEST_F(BadInput, NoRequestOnTheLines_FailsTheData) {
  const std::string still = folder.file("still.csv", "time_ns,MA,SLO\n0,1,1\n100000,1,1\n");
  expect_error(run("decode {} -f {}", still, usual), 1, "no request cycle");
  const std::string unnamed = folder.file("unnamed.csv", "time_ns,A,B\n0,1,1\n100000,1,1\n");
  EXPECT_EQ(run("decode {} -f {}", unnamed, usual).status, 1);
}

TEST_F(BadInput, EndlessToken_IsRefusedInBoundedMemory) {
  const std::string piece(1'000'000, 'a');
  for (const char* begin :
       {"", "$timescale 1ns $end\n$var wire 1 ! MA $end\n$enddefinitions $end\n#", "$comment ",
        "time_ns,MA,SLO\n"}) {
    for (const char* name : {"endless.vcd", "endless.csv"}) {
      SCOPED_TRACE(std::string(name) + ": " + begin);
      const std::string path = folder.file(name, begin);
      std::ofstream file(path, std::ios::binary | std::ios::app);
      for (int i = 0; i < 100; ++i) file << piece;
      file.close();
      const Outcome outcome = run_measured({"decode", path, "-f", usual});
      expect_error(outcome, 3, name);
      EXPECT_LT(outcome.err.size(), 1'000U);
      if (!sanitized()) {
        EXPECT_LT(outcome.peak_kib, 40'000);
      }
    }
  }
}

TEST_F(BadInput, AccessFileThatCannotBeRead_IsRefusedWithItsLine) {
  const auto simulate = [&](const std::string& file) {
    return run_measured(
        {"simulate", "-f", usual, "--access", "@" + file, "-o", folder.path("line.vcd")});
  };
  // One line of 100 MB.
  const std::string endless = folder.file("endless", "read:0x42\n");
  std::filesystem::resize_file(endless, 100'000'000);
  const Outcome refused = simulate(endless);
  expect_error(refused, 3, "endless: line 2: longer than 16384 bytes");
  if (!sanitized()) {
    EXPECT_LT(refused.peak_kib, 40'000);
  }
  // Can be opened; reading its first page fails.
  expect_error(simulate("/proc/self/mem"), 3, "/proc/self/mem: line 1: cannot be read");
  const std::string many = folder.file("many", "");
  std::ofstream file(many, std::ios::binary);
  for (int i = 0; i < 1'000'001; ++i) file << "read:0\n";
  file.close();
  expect_error(simulate(many), 3, "many: line 1000001: more than 1000000 accesses");
  EXPECT_FALSE(std::filesystem::exists(folder.path("line.vcd")));
}

// The status of `biss WORDS… | head -c 1`: the reader closes the pipe after one byte.
int status_with_short_reader(const Folder& folder, const std::string& words) {
  const std::string status = folder.path("status");
  const std::string line = std::string("{ '") + BISS_COMMAND + "' " + words +
                           " 2>/dev/null; echo $? >'" + status + "'; } | head -c 1 >/dev/null";
  EXPECT_EQ(std::system(line.c_str()), 0);
  return std::atoi(content_of(status).c_str());
}

TEST_F(BadInput, ReaderThatLeaves_GetsTheJudgementAndTheOtherOutputsDone) {
  const std::string capture = folder.path("bad.csv");
  const std::string truth = folder.path("truth.csv");
  const std::string simulate = std::string("simulate -f ") + usual;
  // Only the last row is bad, and the rows before it exceed the capacity of a pipe.
  run_ok("simulate -f {} --cycles 3000 --fault flip@2999,bit=9 -o {}", usual, capture);
  const std::string decode = "decode '" + capture + "' -f " + usual + " --to csv";
  EXPECT_EQ(status_with_short_reader(folder, decode + " --fail-on crc"), 1);
  EXPECT_EQ(status_with_short_reader(folder, decode), 0);
  EXPECT_EQ(
      status_with_short_reader(folder, simulate + " --cycles 1000 -o - --truth '" + truth + "'"),
      0);
  EXPECT_EQ(rows_of(content_of(truth)).size(), 1'000U);
}

// The archive with `gap` bytes before it: all its offsets grow by `gap`.
std::string with_gap(std::string archive, std::uint32_t gap) {
  const auto grow = [&](std::size_t at) {
    std::uint32_t offset = 0;
    std::memcpy(&offset, &archive[at], sizeof offset);
    offset += gap;
    std::memcpy(&archive[at], &offset, sizeof offset);
  };
  for (std::size_t at = archive.find("PK\1\2"); at != std::string::npos;
       at = archive.find("PK\1\2", at + 1)) {
    grow(at + 42);
  }
  grow(archive.rfind("PK\5\6") + 16);
  std::string front("PK\3\4");
  front.resize(gap);
  return front + archive;
}

// A session too large for memory is copied to the folder that TMPDIR names.
TEST_F(BadInput, TemporaryFolder_IsTheOneOfTheEnvironment) {
  const std::string small = folder.path("small.sr");
  run_ok("simulate -f {} --cycles 30 -o {}", usual, small);
  const std::string session = folder.file("line.sr", with_gap(content_of(small), 20'000'000));
  const auto status_with = [&](const std::string& temporary) {
    const std::string line = "cat '" + session + "' | TMPDIR='" + temporary + "' '" + BISS_COMMAND +
                             "' decode - -f " + usual + " >'" + folder.path("out") + "' 2>&1";
    return WEXITSTATUS(std::system(line.c_str()));
  };
  EXPECT_EQ(status_with(folder.path("missing")), 3);
  EXPECT_EQ(status_with(folder.path("")), 0);
}

TEST_F(BadInput, MemoryThatEndsInAWorker_IsAnErrorOfOneLine) {
  // A sanitized process reserves more than any limit.
  if (sanitized()) return;
  int refused = 0;
  for (int kib = 14'000; kib < 36'000; kib += 2'000) {
    SCOPED_TRACE(kib);
    const Outcome outcome =
        run_limited(fmt::format("-v {}", kib),
                    Words("safety sequences -f fs-36-28 --frames 2000 --faults 5 --threads 4"));
    // The loader itself ends with 127.
    if (outcome.status == 0 || outcome.status == 127) continue;
    expect_error(outcome, 3, "");
    ++refused;
  }
  EXPECT_GT(refused, 0);
}

TEST_F(BadInput, FreeRunningLinesOfManyEdges_StayInBoundedMemory) {
  const std::string path = folder.file("free.csv", "time_ns,MA,SLO\n");
  std::ofstream file(path, std::ios::binary | std::ios::app);
  for (int i = 0; i < 2'000'000; ++i) file << i * 500 << (i % 2 == 0 ? ",1,0\n" : ",0,1\n");
  file.close();
  const Outcome outcome = run_measured({"decode", path, "-f", usual});
  EXPECT_NE(outcome.status, 128 + 9) << outcome.err;
  EXPECT_LE(outcome.status, 1) << outcome.err;
  if (!sanitized()) {
    EXPECT_LT(outcome.peak_kib, 60'000);
  }
}

TEST_F(BadInput, FormatWithAMistake_PointsAtIt) {
  good_capture(folder, ".csv");
  const std::string capture = folder.path("good.csv");
  for (const char* format : {"",
                             "pos",
                             "pos0",
                             "pos65",
                             "pos26,",
                             ",pos26",
                             "pos26,pos26",
                             "pos26 nE",
                             "pos26,nE,nE",
                             "nE,E",
                             "pos26,crc6,nW",
                             "crc6",
                             "pos64,nE,crc6",
                             "pos26,crc2",
                             "pos26,crc17",
                             "pos26,crc9",
                             "pos26,crc6:43",
                             "pos26,crc6:0x",
                             "pos26,crc6:0x999999999999",
                             "pos26,crc6:0x80",
                             "pos26,crc6:0x43:0x40",
                             "pos26;cds1",
                             "pos26;cds0;cds0",
                             "mt12,mt12",
                             "pos26,mt12",
                             "pos1+pos1+pos1+pos1+pos1+pos1+pos1+pos1+pos1",
                             "POS26",
                             "pos26\n",
                             "resolut-26",
                             "bp3:0x0000",
                             "bp3:zz",
                             "pos99999999999999999999"}) {
    SCOPED_TRACE(format);
    for (const std::string verb : {"decode", "crc", "plan", "simulate"}) {
      const std::string output = folder.path("never.csv");
      SCOPED_TRACE(verb);
      Words words{verb, "-f", format};
      if (verb == "decode") words.push_back(capture);
      if (verb == "crc") words.emplace_back("0");
      if (verb == "simulate") words.insert(words.end(), {"-o", output});
      if (verb == "plan") words.insert(words.end(), {"--clock", "1MHz", "--cable", "1m"});
      expect_usage(run(words), "");
      EXPECT_FALSE(std::filesystem::exists(output));
    }
  }
}

TEST_F(BadInput, PositionTooLargeOrNoNumber_IsWrongUsage) {
  for (const char* position :
       {"67108864", "0x4000000", "99999999999999999999999", "-1", "1.5", "x", "0x", "1e3"}) {
    SCOPED_TRACE(position);
    expect_usage(run("crc -f {} -- {}", usual, position), "position");
  }
}

TEST_F(BadInput, OutputThatCannotBeWritten_IsAnInputOutputError) {
  good_capture(folder, ".csv");
  expect_error(run("decode {} -o {}", folder.path("good.csv"), folder.path("no/such/folder")), 3,
               "no/such/folder");
  expect_error(run("decode {} -o /dev/full", folder.path("good.csv")), 3, "/dev/full");
}

// The content of every file in a folder, by name.
std::map<std::string, std::string> contents_of(const Folder& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path(""))) {
    contents[entry.path().filename()] = content_of(entry.path());
  }
  return contents;
}

// Words of a command; those that begin with `%` are files in the folder.
std::vector<std::string> words_in(const Folder& folder, const std::string& line) {
  std::istringstream stream(line);
  Words words;
  for (std::string word; stream >> word;) {
    const std::size_t file = word.find('%');
    if (file != std::string::npos) word.replace(file, 1, folder.path(""));
    words.push_back(word);
  }
  return words;
}

void expect_same_file(const Folder& folder, const std::string& line,
                      const std::filesystem::path& input = "/dev/null") {
  SCOPED_TRACE(line);
  const auto before = contents_of(folder);
  expect_usage(run(words_in(folder, line), input), "are the same file; name another one");
  EXPECT_EQ(contents_of(folder), before);
}

TEST_F(BadInput, OutputOntoAnInput_IsWrongUsageAndLeavesIt) {
  good_capture(folder, ".vcd");
  folder.file("encoder.eds", "[registers]\nEDS_BANK = 2\n[common]\nTMA = 100ns\n");
  folder.file("list", "read:0x42\n");
  run_ok(words_in(folder, "eds build %encoder.eds --force -o %dump.hex"));
  run_ok(words_in(folder, "safety campaign -f rxm --frames 100 --state %state"));
  const std::string path = folder.path("good.vcd");
  std::filesystem::create_symlink(path, folder.path("link.vcd"));
  std::filesystem::create_hard_link(path, folder.path("hard.vcd"));
  for (const char* line :
       {"decode %good.vcd -f pos26,nE,nW,crc6 -o %good.vcd",
        "decode %good.vcd -f pos26,nE,nW,crc6 -o %./good.vcd",
        "decode %good.vcd -f pos26,nE,nW,crc6 -o %link.vcd",
        "decode %good.vcd -f pos26,nE,nW,crc6 -o %hard.vcd",
        "decode --ma %good.vcd:MA --slo %good.vcd:SLO -f pos26,nE,nW,crc6 -o %good.vcd",
        "check %link.vcd -f pos26,nE,nW,crc6 --to table -o %good.vcd",
        "registers %good.vcd --to table -o %good.vcd",
        "registers %good.vcd --dump %hard.vcd",
        "simulate -f pos26,nE,nW,crc6 --ma-from %good.vcd -o %good.vcd",
        "simulate -f pos26,nE,nW,crc6 --ma-from %good.vcd -o %new.vcd --truth %link.vcd",
        "simulate -f pos26,nE,nW,crc6 --slo-from %good.vcd -o %new.vcd --readings %good.vcd",
        "simulate --registers %dump.hex -f pos18,nE,nW,crc6 -o %dump.hex",
        "simulate --registers 0:%dump.hex -f pos18,nE,nW,crc6 -o %dump.hex",
        "simulate -f pos18,nE,nW,crc6 --access @%list -o %list",
        "simulate -f pos18,nE,nW,crc6 --access @%list -o %new.vcd --outcomes %list",
        "eds build %encoder.eds -o %encoder.eds",
        "eds show %dump.hex -o %dump.hex",
        "eds check %dump.hex -o %dump.hex",
        "eds diff %dump.hex %encoder.eds -o %encoder.eds",
        "eds advise %dump.hex -o %dump.hex",
        "safety campaign -f rxm --frames 100 --state %state -o %state",
        "safety campaign merge %state -o %state",
        "safety campaign merge %state --state %state"}) {
    expect_same_file(folder, line);
  }
  expect_same_file(folder, "decode - -f pos26,nE,nW,crc6 -o %good.vcd", path);
}

TEST_F(BadInput, TwoOutputsInOneFile_AreWrongUsage) {
  good_capture(folder, ".vcd");
  std::filesystem::create_symlink(folder.path("missing"), folder.path("link"));
  for (const char* line : {"simulate -f pos26,nE,nW,crc6 -o %both.csv --truth %both.csv",
                           "simulate -f pos26,nE,nW,crc6 -o %link --truth %missing",
                           "simulate -f pos26,nE,nW,crc6 -o - --truth -",
                           "simulate -f pos26,nE,nW,crc6 --access read:0 -o %q --outcomes %./q",
                           "simulate -f pos26,nE,nW,crc6 --slo-from %good.vcd -o %q --readings %q",
                           "registers %good.vcd -o %q --dump %q",
                           "safety campaign -f rxm --frames 100 --state %q -o %q"}) {
    expect_same_file(folder, line);
  }
  // /dev/null may be the target of several outputs.
  run_ok("simulate -f {} -o /dev/null --truth /dev/null", usual);
}

TEST_F(BadInput, InputThatStandardOutputAppendsTo_IsWrongUsage) {
  const std::string capture = good_capture(folder, ".vcd");
  const std::string path = folder.path("good.vcd");
  const std::string line = std::string("'") + BISS_COMMAND + "' decode '" + path + "' -f " + usual +
                           " >>'" + path + "' 2>'" + folder.path("err") + "'";
  EXPECT_EQ(WEXITSTATUS(std::system(line.c_str())), 2);
  EXPECT_THAT(content_of(folder.path("err")), testing::HasSubstr("are the same file"));
  EXPECT_EQ(content_of(path), capture);
}

TEST_F(BadInput, QuantityWithoutUnit_IsWrongUsage) {
  good_capture(folder, ".vcd");
  for (const char* line :
       {"plan -f resolute-26 --clock 10", "plan -f resolute-26 --cable 50",
        "simulate -f resolute-26 --rate 16 -o %x.vcd", "decode %good.vcd --since 1",
        "simulate -f resolute-26 --sample-rate 200 -o %x.sr"}) {
    SCOPED_TRACE(line);
    expect_usage(run(words_in(folder, line)), "no unit; use");
    EXPECT_EQ(folder.files(), 1U);
  }
  run_ok(words_in(folder, "plan -f resolute-26 --clock 10MHz --cable 0"));
}

TEST_F(BadInput, EmptyValue_IsWrongUsageAndNotTakenForNone) {
  good_capture(folder, ".vcd");
  const std::string capture = folder.path("good.vcd");
  for (const char* option : {"-f", "--ack-max", "--ack-clocks", "--timeout", "--release",
                             "--clock-max", "--cycle-min", "--since", "--ma", "--fail-on", "-o"}) {
    SCOPED_TRACE(option);
    expect_usage(run("decode {} {} {}", capture, option, ""), "empty; a value is needed");
    if (std::string_view(option).starts_with("--")) {
      expect_usage(run("decode {} {} pos26,nE,nW,crc6", capture, std::string(option) + "="),
                   "empty; a value is needed");
    }
  }
  for (const char* option : {"--drift", "--motion", "--fault", "--access", "--registers",
                             "--counter-start", "--truth", "--ma-from"}) {
    SCOPED_TRACE(option);
    expect_usage(run("simulate -f {} {} {} -o {}", usual, option, "", folder.path("never.vcd")),
                 "empty; a value is needed");
    EXPECT_EQ(folder.files(), 1U);
  }
  expect_usage(run("safety campaign -f rxm --shard {}", ""), "empty; a value is needed");
}

TEST_F(BadInput, NegativeTime_IsATimeOfTheCapture) {
  good_capture(folder, ".csv");
  // All times 1 ms earlier.
  const std::string capture = rewritten(folder, "early.csv", folder.path("good.csv"), [](Row& row) {
    row["time_ns"] = std::to_string(std::stod(row["time_ns"]) - 1'000'000);
  });
  const auto all = rows_of(run("decode {} -f {} --to csv", capture, usual).out);
  ASSERT_EQ(all.size(), 30U);
  const Outcome part =
      run_ok("decode {} -f {} --to csv --since -900us --until=-1us", capture, usual);
  std::size_t inside = 0;
  for (const Row& row : all) {
    const double time = std::stod(row.at("time_ns"));
    inside += time >= -900'000 && time <= -1'000 ? 1U : 0U;
  }
  EXPECT_GT(inside, 3U);
  EXPECT_LT(inside, 27U);
  EXPECT_EQ(rows_of(part.out).size(), inside);
}

TEST_F(BadInput, MoreCyclesThanTimeCanCount_IsWrongUsage) {
  expect_error(run("simulate -f pos1 --rate 1Hz --cycles 9300000 -o {}", folder.path("long.csv")),
               2, "8640000 cycles at this rate");
}

TEST_F(BadInput, NoCycleInTheTimeAskedFor_SaysSo) {
  good_capture(folder, ".vcd");
  expect_error(run("decode {} -f {} --since 900s", folder.path("good.vcd"), usual), 1,
               "no request cycle between --since and --until; outside: 30");
  expect_error(run("decode {} -f {} --since 900s --until 1s", folder.path("good.vcd"), usual), 2,
               "--until: is before --since");
}

}  // namespace biss::verbs::bad_input_test
