// Bad input of every kind: one clear line, the right exit status, bounded memory, no partial file.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "tests/cli/run_command.hpp"

namespace biss::cli {
namespace {

constexpr const char* usual = "pos26,nE,nW,crc6";

constexpr bool sanitized() {
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
  return true;
#endif
#endif
  return false;
}

// One line on stderr that names the program, and, where a summary precedes it, the last one.
void expect_one_line(const Outcome& outcome, const std::string& part) {
  const std::size_t last = outcome.err.rfind("biss: ");
  ASSERT_NE(last, std::string::npos) << outcome.err;
  const std::string line = outcome.err.substr(last);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << outcome.err;
  EXPECT_TRUE(line.ends_with("\n"));
  EXPECT_NE(line.find(part), std::string::npos) << line;
  EXPECT_EQ(outcome.err.find("biss: "), last) << "more than one error: " << outcome.err;
}

std::string good_capture(const Folder& folder, const std::string& extension) {
  const std::string path = folder.path("good" + extension);
  EXPECT_EQ(run({"simulate", "-f", usual, "--cycles", "30", "-o", path}).status, 0);
  return content_of(path);
}

// Decodes into a file that must stay as it was.
void expect_refused(const Folder& folder, const std::string& input, int status,
                    const std::string& part) {
  SCOPED_TRACE(input);
  const std::string output = folder.file("rows.csv", "old rows\n");
  const std::size_t files = folder.files();
  const Outcome outcome = run({"decode", input, "-f", usual, "--to", "csv", "-o", output});
  EXPECT_EQ(outcome.status, status) << outcome.err;
  expect_one_line(outcome, part);
  EXPECT_EQ(content_of(output), "old rows\n");
  EXPECT_EQ(folder.files(), files) << "a temporary file was left";
  EXPECT_EQ(outcome.out, "");
}

TEST(BadInput, WhatIsNoCapture_IsRefused) {
  const Folder folder;
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

TEST(BadInput, TimeThatRunsBackwards_IsNamedWithItsPlace) {
  const Folder folder;
  expect_refused(folder, folder.file("back.csv", "time_ns,MA,SLO\n0,1,1\n100,0,1\n50,1,1\n"), 3,
                 "back.csv:4");
  const std::string vcd = good_capture(folder, ".vcd");
  expect_refused(folder, folder.file("back.vcd", vcd + "#5\n0!\n"), 3, "back.vcd:");
}

TEST(BadInput, HalfAFile_GivesWhatIsWholeOrAnErrorNeverAWrongRow) {
  const Folder folder;
  for (const char* extension : {".vcd", ".csv"}) {
    const std::string text = good_capture(folder, extension);
    const auto whole = rows_of(
        run({"decode", folder.path(std::string("good") + extension), "-f", usual, "--to", "csv"})
            .out);
    ASSERT_EQ(whole.size(), 30U);
    for (std::size_t cut = 10; cut < text.size(); cut += text.size() / 23) {
      SCOPED_TRACE(std::string(extension) + " cut at " + std::to_string(cut));
      const std::string half = folder.file(std::string("half") + extension, text.substr(0, cut));
      const Outcome outcome = run({"decode", half, "-f", usual, "--to", "csv"});
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

TEST(BadInput, ReadErrorBehindGoodRows_PipesThemAndFails) {
  const Folder folder;
  const std::string capture =
      folder.file("tail.vcd", good_capture(folder, ".vcd") + "#99999999999999\nnonsense\n");
  expect_refused(folder, capture, 3, "tail.vcd:");
  const Outcome piped = run({"decode", capture, "-f", usual, "--to", "csv"});
  EXPECT_EQ(piped.status, 3);
  EXPECT_EQ(rows_of(piped.out).size(), 30U);
}

TEST(BadInput, UnknownLevels_AreRowsOfTheirOwn) {
  const Folder folder;
  std::string text = good_capture(folder, ".csv");
  auto line = text.begin();
  for (int i = 0; i < 400; ++i) line = std::find(line, text.end(), '\n') + 1;
  const auto comma = std::find(line, text.end(), ',');
  *(comma + 1) = 'x';
  *(comma + 3) = 'z';
  const Outcome outcome = run({"decode", folder.file("x.csv", text), "-f", usual, "--to", "csv"});
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  std::size_t unknown = 0;
  std::size_t good = 0;
  for (const Row& row : rows_of(outcome.out)) {
    unknown += row.at("status") == "unknown_level" ? 1U : 0U;
    good += row.at("status") == "ok" ? 1U : 0U;
  }
  EXPECT_EQ(unknown, 1U);
  EXPECT_EQ(good, 29U);
}

TEST(BadInput, LinesThatAreNotThere_AreWrongUsage) {
  const Folder folder;
  good_capture(folder, ".csv");
  const std::string capture = folder.path("good.csv");
  for (const std::vector<std::string>& options : std::vector<std::vector<std::string>>{
           {"--ma", "CLK"}, {"--slo", "other.csv:SLO"}, {"--ma", "SLO", "--slo", "SLO"}}) {
    std::vector<std::string> words{"decode", capture};
    words.insert(words.end(), options.begin(), options.end());
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    expect_one_line(outcome, "");
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(BadInput, NoRequestOnTheLines_FailsTheData) {
  const Folder folder;
  const std::string still = folder.file("still.csv", "time_ns,MA,SLO\n0,1,1\n100000,1,1\n");
  const Outcome outcome = run({"decode", still, "-f", usual});
  EXPECT_EQ(outcome.status, 1) << outcome.err;
  expect_one_line(outcome, "no request cycle");
  const std::string unnamed = folder.file("unnamed.csv", "time_ns,A,B\n0,1,1\n100000,1,1\n");
  EXPECT_EQ(run({"decode", unnamed, "-f", usual}).status, 1);
}

TEST(BadInput, EndlessToken_IsRefusedInBoundedMemory) {
  const Folder folder;
  // Written piece by piece: the memory of this process would count as the command's.
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
      const Outcome outcome = run({"decode", path, "-f", usual});
      EXPECT_EQ(outcome.status, 3) << outcome.err.substr(0, 500);
      expect_one_line(outcome, name);
      EXPECT_LT(outcome.err.size(), 1'000U);
      if (!sanitized()) {
        EXPECT_LT(outcome.peak_kib, 40'000);
      }
    }
  }
}

TEST(BadInput, FreeRunningLinesOfManyEdges_StayInBoundedMemory) {
  const Folder folder;
  const std::string path = folder.file("free.csv", "time_ns,MA,SLO\n");
  std::ofstream file(path, std::ios::binary | std::ios::app);
  for (int i = 0; i < 2'000'000; ++i) file << i * 500 << (i % 2 == 0 ? ",1,0\n" : ",0,1\n");
  file.close();
  const Outcome outcome = run({"decode", path, "-f", usual});
  EXPECT_NE(outcome.status, 128 + 9) << outcome.err;
  EXPECT_LE(outcome.status, 1) << outcome.err;
  if (!sanitized()) {
    EXPECT_LT(outcome.peak_kib, 60'000);
  }
}

TEST(BadInput, FormatWithAMistake_PointsAtIt) {
  const Folder folder;
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
      std::vector<std::string> words{verb, "-f", format};
      if (verb == "decode") words.push_back(capture);
      if (verb == "crc") words.emplace_back("0");
      if (verb == "simulate") words.insert(words.end(), {"-o", output});
      // Without a format `decode` gives structure only; an empty one is as if it were not given.
      if (verb == "decode" && *format == '\0') continue;
      if (verb == "plan") words.insert(words.end(), {"--clock", "1MHz", "--cable", "1m"});
      const Outcome outcome = run(words);
      EXPECT_EQ(outcome.status, 2) << verb << ": " << outcome.err;
      expect_one_line(outcome, "");
      EXPECT_EQ(outcome.out, "");
      EXPECT_FALSE(std::filesystem::exists(output));
    }
  }
}

TEST(BadInput, PositionTooLargeOrNoNumber_IsWrongUsage) {
  for (const char* position :
       {"67108864", "0x4000000", "99999999999999999999999", "-1", "1.5", "x", "0x", "1e3"}) {
    const Outcome outcome = run({"crc", "-f", usual, "--", position});
    EXPECT_EQ(outcome.status, 2) << position;
    expect_one_line(outcome, "position");
    EXPECT_EQ(outcome.out, "");
  }
}

TEST(BadInput, OutputThatCannotBeWritten_IsAnInputOutputError) {
  const Folder folder;
  good_capture(folder, ".csv");
  const Outcome outcome =
      run({"decode", folder.path("good.csv"), "-o", folder.path("no/such/folder")});
  EXPECT_EQ(outcome.status, 3);
  expect_one_line(outcome, "no/such/folder");
  const Outcome full = run({"decode", folder.path("good.csv"), "-o", "/dev/full"});
  EXPECT_EQ(full.status, 3);
  expect_one_line(full, "/dev/full");
}

TEST(BadInput, OutputOntoTheCapture_IsWrongUsageAndLeavesIt) {
  const Folder folder;
  const std::string capture = good_capture(folder, ".vcd");
  const std::string path = folder.path("good.vcd");
  std::filesystem::create_symlink(path, folder.path("link.vcd"));
  std::filesystem::create_hard_link(path, folder.path("hard.vcd"));
  for (const char* name : {"good.vcd", "./good.vcd", "link.vcd", "hard.vcd"}) {
    SCOPED_TRACE(name);
    const Outcome outcome = run({"decode", path, "-f", usual, "-o", folder.path(name)});
    EXPECT_EQ(outcome.status, 2);
    expect_one_line(outcome, "is the capture itself");
    EXPECT_EQ(content_of(path), capture);
  }
  EXPECT_EQ(run({"decode", "-", "-f", usual, "-o", path}, path).status, 2);
  EXPECT_EQ(content_of(path), capture);
}

TEST(BadInput, TruthAndCaptureInOneFile_IsWrongUsage) {
  const Folder folder;
  for (const std::string& path : {folder.path("both.csv"), std::string("-")}) {
    const Outcome outcome = run({"simulate", "-f", usual, "-o", path, "--truth", path});
    EXPECT_EQ(outcome.status, 2);
    expect_one_line(outcome, "name the same file");
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path("both.csv")));
}

TEST(BadInput, MoreCyclesThanTimeCanCount_IsWrongUsage) {
  const Folder folder;
  const Outcome outcome = run({"simulate", "-f", "pos1", "--rate", "1Hz", "--cycles", "9300000",
                               "-o", folder.path("long.csv")});
  EXPECT_EQ(outcome.status, 2);
  expect_one_line(outcome, "8640000 cycles at this rate");
}

TEST(BadInput, NoCycleInTheTimeAskedFor_SaysSo) {
  const Folder folder;
  good_capture(folder, ".vcd");
  const Outcome outcome = run({"decode", folder.path("good.vcd"), "-f", usual, "--since", "900s"});
  EXPECT_EQ(outcome.status, 1);
  expect_one_line(outcome, "no request cycle between --since and --until; outside: 30");
}

}  // namespace
}  // namespace biss::cli
