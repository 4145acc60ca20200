// `biss convert`: what both formats hold comes back, and what one cannot hold is said.
#include <random>

#include "tests/cli/run_command.hpp"

namespace biss::verbs::convert_test {

using Convert = InFolder;
using testing::HasSubstr;
using testing::Not;

Outcome convert(const Words& arguments) { return run(Words("convert") + arguments); }

// Event CSV of these lines; every time is a multiple of `step` nanoseconds, and all lines have a level
// at the first.
std::string random_csv(std::uint64_t seed, const std::string& names, std::size_t lines,
                       std::int64_t first_ps, std::int64_t step_ps, bool unknown) {
  std::mt19937_64 random(seed);
  std::string text = "time_ps," + names + '\n';
  std::int64_t time = first_ps;
  std::string levels(lines, '1');
  for (int row = 0; row < 500; ++row) {
    text += std::to_string(time);
    for (const char level : levels) text += {',', level};
    text += '\n';
    time += step_ps * static_cast<std::int64_t>(1 + random() % 50);
    char& level = levels[random() % lines];
    const char before = level;
    while (level == before) level = (unknown ? "01x" : "01")[random() % (unknown ? 3 : 2)];
  }
  return text;
}

// Converts a file to `to` and back to the format of the file, which must then have the same bytes.
void expect_back(const Folder& folder, const std::string& from, const std::string& extension,
                 const std::string& to, const Words& there, const Words& back) {
  SCOPED_TRACE(extension + " -> " + to);
  ok(convert(Words{from, folder.path("there" + to)} + there));
  ok(convert(Words{folder.path("there" + to), folder.path("back" + extension)} + back));
  EXPECT_TRUE(content_of(folder.path("back" + extension)) == content_of(from));
}

bool is_sampled(const std::string& extension) {
  return extension == ".sr" || extension == ".dsl" || extension == ".bin" || extension == ".raw";
}

bool is_raw(const std::string& extension) { return extension == ".bin" || extension == ".raw"; }

// Raw samples hold neither their rate nor names.
Words reading(const std::string& extension) {
  if (!is_raw(extension)) return {};
  return {"--raw-rate", "100MHz", "--line", "D0=MA", "--line", "D1=SLO"};
}

TEST_F(Convert, EveryPairOfFormats_GivesTheSameFileBack) {
  const std::string base =
      folder.file("base.csv", random_csv(7'801, "MA,SLO", 2, 0, 10'000, false));
  const Words all(".vcd .csv .saleae.csv .sr .dsl .bin .raw");
  for (const std::string& from : all) {
    const std::string first = folder.path("first" + from);
    const Words rate("--rate 100MHz");
    ASSERT_EQ(convert(Words{base, first} + (is_sampled(from) ? rate : Words())).status, 0);
    for (const std::string& to : all) {
      Words there = reading(from);
      Words back = reading(to);
      if (is_sampled(to) && !is_sampled(from)) there = there + rate;
      if (is_sampled(from) && !is_sampled(to)) back = back + rate;
      expect_back(folder, first, from, to, there, back);
    }
  }
}

TEST_F(Convert, PicosecondsAndUnknownLevels_ComeBackFromFormatsOfChanges) {
  for (const std::int64_t first : {0, -987'654'321}) {
    const std::string base =
        folder.file("base.csv", random_csv(7'802, "MA,SLO,\"a b,c\"", 3, first, 1, true));
    Words all{".csv", ".saleae.csv"};
    if (first == 0) all.push_back(".vcd");
    for (const std::string& from : all) {
      EXPECT_THAT(ok(convert({base, folder.path("first" + from)})).err, Not(HasSubstr("lost")));
      for (const std::string& to : all) {
        // A VCD has no blanks in names.
        Words back;
        if (to == ".vcd" && from != to)
          back = {"--line", "MA", "--line", "SLO", "--line", "a_b,c=a b,c"};
        expect_back(folder, folder.path("first" + from), from, to, {}, back);
      }
    }
  }
}

TEST_F(Convert, SaleaeBinary_HoldsOneLineWithItsGaps) {
  for (const bool unknown : {false, true}) {
    const std::string base = folder.file(
        "base.csv", random_csv(7'803, "there", 1, -1'000, 1, unknown) + "9999999999999,1\n");
    ASSERT_EQ(convert({base, folder.path("first.csv")}).status, 0);
    ASSERT_EQ(convert({base, folder.path("first.saleae.csv")}).status, 0);
    expect_back(folder, folder.path("first.csv"), ".csv", ".saleae.bin", {}, {});
    expect_back(folder, folder.path("first.saleae.csv"), ".saleae.csv", ".saleae.bin", {}, {});
    const std::string bytes = content_of(folder.path("there.saleae.bin"));
    EXPECT_EQ(bytes.substr(0, 8), "<SALEAE>");
    EXPECT_EQ(bytes[8], unknown ? '\1' : '\0');
  }
}

TEST_F(Convert, SimulatedLine_DecodesTheSameFromEveryFormat) {
  const std::string line = folder.path("line.vcd");
  run_ok("simulate -f resolute-26 --sample-rate 100MHz -o {} --cycles 20", folder.path("line.sr"));
  ASSERT_EQ(convert({folder.path("line.sr"), line}).status, 0);
  const auto decoded = [&](const Words& files) {
    return run(Words("decode -f resolute-26 --to csv --resolution 10ns") + files).out;
  };
  const std::string wanted = decoded({line});
  EXPECT_EQ(rows_of(wanted).size(), 20U);
  for (const std::string to : {".csv", ".saleae.csv", ".sr", ".dsl"}) {
    ok(convert({folder.path("line.sr"), folder.path("other" + to)}));
    EXPECT_EQ(decoded({folder.path("other" + to)}), wanted) << to;
  }
  ASSERT_EQ(convert({line, folder.path("MA.saleae.bin"), "--line", "MA"}).status, 0);
  ASSERT_EQ(convert({line, folder.path("SLO.saleae.bin"), "--line", "SLO"}).status, 0);
  EXPECT_EQ(decoded({folder.path("MA.saleae.bin"), folder.path("SLO.saleae.bin")}), wanted);
  const Outcome joined = ok(convert(
      {folder.path("MA.saleae.bin"), folder.path("SLO.saleae.bin"), folder.path("joined.vcd")}));
  EXPECT_TRUE(content_of(folder.path("joined.vcd")) == content_of(line));
}

TEST_F(Convert, FilesJoined_KeepTheirNamesWhereTheyDiffer) {
  const std::string a = folder.file("a.csv", "time_ns,MA\n0,1\n5,0\n");
  const std::string b = folder.file("b.csv", "time_ns,SLO\n1,1\n");
  const std::string c = folder.file("c.csv", "time_ns,MA\n2,1\n");
  ASSERT_EQ(convert({a, b, folder.path("ab.csv")}).status, 0);
  EXPECT_EQ(content_of(folder.path("ab.csv")), "time_ns,MA,SLO\n0.000,1,\n1.000,1,1\n5.000,0,1\n");
  ASSERT_EQ(convert({a, c, "-o", folder.path("ac.csv")}).status, 0);
  EXPECT_THAT(content_of(folder.path("ac.csv")), HasSubstr("a.csv:MA,"));
}

TEST_F(Convert, TimeRange_BeginsWithTheLevelsThere) {
  const std::string in =
      folder.file("in.csv", "time_ns,MA,SLO\n0,1,\n10,0,1\n20,1,1\n30,0,0\n40,1,0\n");
  const std::string out = folder.path("out.csv");
  ASSERT_EQ(convert({in, out, "--since", "15ns", "--until", "30ns"}).status, 0);
  EXPECT_EQ(content_of(out), "time_ns,MA,SLO\n15.000,0,1\n20.000,1,1\n30.000,0,0\n");
  ASSERT_EQ(convert({in, out, "--since", "20ns", "--until", "25ns"}).status, 0);
  EXPECT_EQ(content_of(out), "time_ns,MA,SLO\n20.000,1,1\n25.000,1,1\n");
  EXPECT_THAT(convert({in, out, "--since", "1ms"}), fails(1, "ends earlier, at 40 ns"));
  EXPECT_EQ(convert({in, out, "--since", "2ns", "--until", "1ns"}).status, 2);
  const std::string before = content_of(out);
  EXPECT_THAT(convert({in, out, "--until", "-1ns"}),
              fails(1, "no level of the lines before -1 ns"));
  EXPECT_EQ(convert({in, out, "--line", "SLO", "--until", "5ns"}).status, 1);
  EXPECT_EQ(content_of(out), before);
  EXPECT_EQ(convert({in, out, "--until", "0ns"}).status, 0);
  // Samples begin at the begin of the range.
  const std::string raw = folder.path("out.bin");
  const Outcome done = ok(convert({in, raw, "--since", "15ns", "--rate", "200MHz"}));
  EXPECT_EQ(content_of(raw), std::string("\2\3\3\0\0\1", 6));
  EXPECT_THAT(done.err, HasSubstr("every time by -15 ns"));
}

TEST_F(Convert, LinesSelected_AreRenamedAndOrdered) {
  const std::string in = folder.file("in.csv", "time_ns,a,b=c,d\n0,1,0,1\n10,0,1,0\n");
  const std::string out = folder.path("out.csv");
  ASSERT_EQ(convert({in, out, "--line", "d=MA", "--line", "b=c"}).status, 0);
  EXPECT_EQ(content_of(out), "time_ns,MA,b=c\n0.000,1,0\n10.000,0,1\n");
  for (const Words& wrong : {Words{"--line", "x"},
                             {"--line", "a", "--line", "a"},
                             {"--line", "a=d", "--line", "d"},
                             {"--line", "a="}}) {
    EXPECT_THAT(convert(Words{in, out} + wrong), fails(2, "--line")) << wrong[1];
  }
}

TEST_F(Convert, WhatSamplesCannotHold_IsCounted) {
  const std::string in =
      folder.file("in.csv", "time_ns,MA,SLO\n0,1,1\n12,0,1\n13,1,1\n40,0,x\n50,1,1\n100,1,0\n");
  const Outcome done = ok(convert({in, folder.path("out.bin"), "--rate", "100MHz"}));
  EXPECT_THAT(done.err, HasSubstr("2 of 9 changes  "));
  EXPECT_THAT(done.err, HasSubstr("to the next sample, at most 10 ns later"));
  EXPECT_THAT(done.err, HasSubstr("1 of 9 changes  "));
  EXPECT_THAT(done.err, HasSubstr("1 unknown levels"));
  EXPECT_THAT(done.err, HasSubstr("bits 0 to 1 are MA, SLO"));
  EXPECT_THAT(done.err, HasSubstr("--raw-rate 100MHz"));
  EXPECT_EQ(content_of(folder.path("out.bin")), "\3\3\3\3" + std::string("\0", 1) + "\3\3\3\3\3\1");
  const Outcome exact = convert({in, folder.path("out.sr"), "--rate", "1GHz", "--line", "MA"});
  EXPECT_THAT(exact.err, Not(HasSubstr("lost")));
  EXPECT_THAT(exact.err, Not(HasSubstr("moved")));
}

TEST_F(Convert, WhatFormatsOfChangesCannotHold_IsSaid) {
  const std::string in = folder.file("in.csv", "time_ns,my line\n-5,1\n10,0\n");
  const Outcome vcd = ok(convert({in, folder.path("out.vcd")}));
  EXPECT_THAT(vcd.err, HasSubstr("every time by 5 ns"));
  EXPECT_THAT(vcd.err, HasSubstr("name 'my line'"));
  EXPECT_THAT(content_of(folder.path("out.vcd")), HasSubstr("#15000\n0!"));
  ASSERT_EQ(convert({in, folder.path("out.sr"), "--rate", "1GHz"}).status, 0);
  const Outcome rate = convert({folder.path("out.sr"), folder.path("out.csv")});
  EXPECT_THAT(rate.err, HasSubstr("--resolution 1ns"));
  const Outcome two =
      convert({folder.file("two.csv", "time_ns,MA,SLO\n0,1,1\n"), folder.path("two.saleae.bin")});
  EXPECT_THAT(two, fails(2, "--line"));
  const Outcome late = convert({folder.file("late.csv", "time_s,MA\n0,1\n9000000.000000000001,0\n"),
                                folder.path("late.saleae.bin")});
  EXPECT_THAT(late.err, HasSubstr("1 of 2 times"));
}

TEST_F(Convert, WrongUsage_IsNamedAndWritesNothing) {
  const std::string in = folder.file("in.vcd",
                                     "$timescale 1ns $end $var wire 1 ! MA $end "
                                     "$enddefinitions $end #0 1! #10 0!\n");
  const std::string before = content_of(in);
  const auto expect = [&](const Words& arguments, const std::string& part) {
    EXPECT_THAT(convert(arguments), fails(2, part));
  };
  expect({}, "biss convert IN OUT");
  expect({in}, "biss convert IN OUT");
  expect({"-o", folder.path("x.vcd")}, "no capture given");
  expect({in, folder.path("x.txt")}, "--to");
  expect({in, "-"}, "--to");
  expect({in, folder.path("x.sr")}, "--rate");
  expect({in, folder.path("x.csv"), "--rate", "1MHz"}, "--rate");
  expect({in, folder.path("x.csv"), "--to", "png"}, "--to");
  expect({in, in}, "the same file");
  std::filesystem::create_symlink(in, folder.path("link.vcd"));
  expect({in, folder.path("link.vcd")}, "the same file");
  std::filesystem::create_hard_link(in, folder.path("hard.vcd"));
  expect({in, "-o", folder.path("hard.vcd")}, "the same file");
  EXPECT_EQ(folder.files(), 3U);
  EXPECT_EQ(content_of(in), before);
}

TEST_F(Convert, FormatGiven_OverridesTheExtension) {
  const std::string in = folder.file("in.csv", "time_ns,MA\n0,1\n10,0\n");
  const Outcome out = ok(convert({in, "-", "--to", "vcd"}));
  EXPECT_TRUE(out.out.starts_with("$timescale")) << out.out;
  ASSERT_EQ(convert({in, folder.path("x.txt"), "--to", "csv"}).status, 0);
  EXPECT_EQ(content_of(folder.path("x.txt")), "time_ns,MA\n0.000,1\n10.000,0\n");
}

TEST_F(Convert, DamagedCapture_IsConvertedOnlyIfAskedTo) {
  const std::string in = folder.file("in.csv", "time_ns,MA\n0,1\n10,0\n20,?\n");
  const std::string out = folder.path("out.csv");
  EXPECT_THAT(convert({in, out}),
              fails(3, testing::AllOf(HasSubstr("in.csv:4:4"), HasSubstr("--partial"))));
  EXPECT_EQ(folder.files(), 1U);
  EXPECT_THAT(convert({in, out, "--partial"}), fails(3, "in.csv:4:4"));
  EXPECT_EQ(content_of(out), "time_ns,MA\n0.000,1\n10.000,0\n");
}

TEST_F(Convert, MoreSamplesThanADiskHolds_AreRefused) {
  const std::string in = folder.file("in.csv", "time_s,MA\n0,1\n9000000,0\n");
  EXPECT_THAT(convert({in, folder.path("out.sr"), "--rate", "1GHz"}), fails(3, "--until"));
  EXPECT_EQ(folder.files(), 1U);
}

TEST_F(Convert, SmallFileThatDecompressesToALargeOne_NeedsLittleMemory) {
  const std::string in = folder.path("in.csv");
  const std::string made =
      "(printf 'time_ns,MA,SLO\\n0,1,1\\n'; head -c 104857600 /dev/zero | "
      "tr '\\0' '\\n') | gzip -1 >" +
      in + ".gz";
  ASSERT_EQ(std::system(made.c_str()), 0);
  ASSERT_LT(std::filesystem::file_size(in + ".gz"), 1'000'000U);
  const Outcome done = ok(run_measured({"convert", in + ".gz", folder.path("out.vcd")}));
  EXPECT_THAT(content_of(folder.path("out.vcd")), HasSubstr("#0\n1!\n1\"\n"));
#if !defined(__has_feature)
  // A sanitized process needs more. The text alone has 102400 KiB.
  EXPECT_LT(done.peak_kib, 90'000);
#endif
}

class ConvertSigrok : public testing::Test {
 protected:
  static bool runs(const std::string& command) {
    return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
  }

  void SetUp() override {
    if (!runs("sigrok-cli --version"))
      GTEST_SKIP() << "no sigrok-cli: scripts/install-packages test";
    ASSERT_TRUE(
        runs("sigrok-cli -d demo -C D0,D1,D2,D3,D4,D5,D6,D7 --config samplerate=1m "
             "--samples 20000 -O srzip -o " +
             demo_));
    samples_ = theirs(demo_, "");
    ASSERT_EQ(samples_.size(), 20'000U);
  }

  // The samples that sigrok-cli reads in a file, a byte each.
  std::string theirs(const std::string& file, const std::string& options) const {
    const std::string out = folder_.path("theirs.bin");
    EXPECT_TRUE(runs("sigrok-cli " + options + " -i " + file + " -O binary -o " + out));
    std::string samples = content_of(out);
    // Where the input says its rate late, it stands before the samples.
    if (samples.starts_with("META")) samples.erase(0, samples.find('\n') + 1);
    return samples;
  }

  Folder folder_;
  std::string demo_ = folder_.path("demo.sr");
  std::string samples_;
};

TEST_F(ConvertSigrok, SessionOfItsDemo_HasTheSameSamples) {
  ASSERT_EQ(convert({demo_, folder_.path("demo.bin")}).status, 0);
  EXPECT_TRUE(content_of(folder_.path("demo.bin")) == samples_);
}

TEST_F(ConvertSigrok, WhatIsWritten_HasTheSameSamplesThere) {
  ASSERT_EQ(convert({demo_, folder_.path("demo.vcd")}).status, 0);
  ASSERT_EQ(convert({folder_.path("demo.vcd"), folder_.path("ours.sr"), "--rate", "1MHz"}).status,
            0);
  EXPECT_TRUE(theirs(folder_.path("ours.sr"), "") == samples_);
  const std::string from_vcd = theirs(folder_.path("demo.vcd"), "-I vcd:downsample=1000000");
  // It ends before the last time of a VCD.
  EXPECT_TRUE(from_vcd == samples_.substr(0, samples_.size() - 1));
}

}  // namespace biss::verbs::convert_test
