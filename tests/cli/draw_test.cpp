// `biss draw`: cycles of captures and of a simulated line, as text and as SVG.
#include <random>

#include "sim/fault.hpp"
#include "tests/cli/run_command.hpp"

namespace biss::verbs::draw_test {

using DrawVerb = InFolder;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

constexpr const char* format = "pos12,nE,nW,crc6";

Outcome draw(const Words& words) { return run(Words("draw") + words); }

// A simulated cycle with a known position.
Outcome draw_line(const Words& more = {}) {
  return draw(Words("-f {} --clock 5MHz --cable 20m --position 1234", format) + more);
}

std::string simulate(const Folder& folder, const Words& more = {}, const char* cycles = "6") {
  const std::string capture = folder.path("line.csv");
  run_ok(Words("simulate -f {} --clock 1MHz --cable 20m --seed 3 -o {} --cycles {}", format,
               capture, cycles) +
         more);
  return capture;
}

// Every SVG file of a folder is well-formed, and has a title and a description.
bool all_well_formed(const std::string& folder) {
  const std::string command =
      "python3 -c 'import glob, sys, xml.etree.ElementTree as tree\n"
      "for name in glob.glob(sys.argv[1] + \"/*.svg\"):\n"
      "    root = tree.parse(name).getroot()\n"
      "    texts = [child.text for child in root if child.tag.endswith((\"title\", \"desc\"))]\n"
      "    assert len(texts) == 2 and all(texts), name\n"
      "    assert not [e for e in root.iter() if e.tag.endswith(\"script\")], name' '" +
      folder + "'";
  return std::system(command.c_str()) == 0;
}

TEST_F(DrawVerb, SimulatedCycle_HasItsPartsByNameAndValue) {
  const Outcome outcome = ok(draw_line({"--ack", "5", "--width", "240"}));
  EXPECT_EQ(outcome.err, "");
  for (const char* const part :
       {"MA 5 MHz", "line delay 200 ns", " ACK 1 us, 5 clocks ", "│START│CDS=0│", " pos=1234 ",
        "│nE=1 │nW=1 │", "crc=0x14", "│STOP │", "timeout 40.2 us", "CDM=0",
        "CRC received 0x14, expected 0x14: right"}) {
    EXPECT_THAT(outcome.out, HasSubstr(part));
  }
  EXPECT_THAT(outcome.out, Not(HasSubstr("failure")));
}

TEST_F(DrawVerb, LongAckAndTimeout_AreCutWithTheirLength) {
  const Outcome text = draw_line({"--ack", "40", "--width", "300"});
  EXPECT_THAT(text.out, HasSubstr("34 clocks"));
  EXPECT_THAT(text.out, HasSubstr("38.6 us"));
  // 40 clocks of ACK, 24 of the frame: all of them would not fit.
  EXPECT_THAT(text.out, ContainsRegex("clock .* 3 +4 +5 +39 +40 +41"));
  const Outcome svg = draw_line({"--ack", "40", "--to", "svg"});
  EXPECT_THAT(svg.out, HasSubstr(">34 clocks</text>"));
  EXPECT_THAT(svg.out, HasSubstr(">ACK 8 us, 40 clocks</text>"));
}

TEST_F(DrawVerb, Svg_IsWellFormedForEveryFault) {
  for (std::size_t k = 0; k < sim::simulated_fault_count; ++k) {
    const std::string name(sim::fault_list[k].name);
    const Outcome outcome =
        draw(Words("-f fs-36-28 --clock 10MHz --cable 30m --fault {} --cycle 0 --count 2 -o {}",
                   name + "@1", folder.path(name + ".svg")));
    // A fault may leave one cycle where there were two.
    EXPECT_LE(outcome.status, 1) << outcome.err;
  }
  EXPECT_GE(folder.files(), sim::simulated_fault_count - 2);
  EXPECT_TRUE(all_well_formed(folder.path("")));
}

TEST_F(DrawVerb, Svg_NeedsNothingElseAndIsTheSameEachTime) {
  const std::string file = folder.path("cycle.svg");
  ASSERT_EQ(draw_line({"-o", file}).status, 0);
  const std::string svg = content_of(file);
  EXPECT_EQ(svg, draw_line({"--to", "svg"}).out);
  EXPECT_THAT(svg, HasSubstr("<title id=\"title\">cycle 0 at 4 us: ok"));
  EXPECT_THAT(svg, HasSubstr("START; CDS=0; pos=1234; nE=1; nW=1; crc=0x14; STOP; timeout"));
  EXPECT_THAT(svg, HasSubstr("prefers-color-scheme:dark"));
  for (const char* const foreign : {"href", "url(", "@import", "<script", "<image"}) {
    EXPECT_THAT(svg, Not(HasSubstr(foreign)));
  }
}

TEST_F(DrawVerb, WrongChecksum_IsMarkedWithTheExpectedOne) {
  const Outcome text = draw_line({"--fault", "flip@0,bit=7", "--width", "200"});
  EXPECT_THAT(text.out, HasSubstr("cycle 0 at 4 us: crc"));
  EXPECT_THAT(text.out, HasSubstr("injected: flip@bit=7"));
  EXPECT_THAT(text.out, HasSubstr("crc=0x14, expected 0x"));
  EXPECT_THAT(text.out, HasSubstr("▲"));
  EXPECT_THAT(text.out, HasSubstr("crc: received 0x14, expected 0x"));
  // 1234 with bit 7 inverted, and not as a position.
  EXPECT_THAT(text.out, HasSubstr("pos=0x4C2"));
  const Outcome svg = draw_line({"--fault", "flip@0,bit=7", "--to", "svg"});
  EXPECT_THAT(svg.out, HasSubstr("class=\"box crc wrong\""));
  EXPECT_THAT(svg.out, HasSubstr("Failure: crc: received 0x14, expected 0x"));
}

TEST_F(DrawVerb, Failures_StandWithTheirCause) {
  const auto expect = [](const Words& more, const char* cause) {
    EXPECT_THAT(draw_line(more).out, HasSubstr(cause));
  };
  expect({"--fault", "no_answer@0"}, "no_response: SLO does not fall");
  expect({"--fault", "ma_low@0,clock=9.2"}, "truncated: MA stops after ");
  expect({"--fault", "late_start@0"}, "no_start: MA stops before START");
  expect({"--fault", "glitch_ma@0,clock=8.2"}, "ma_clock: MA has an edge");
  expect({"--fault", "slo_low@0,clock=20", "--cycle", "1"}, "not_ready: SLO is low");
}

// The values are those of decode, for positions in any form.
TEST_F(DrawVerb, Values_AreThoseOfDecode) {
  for (const char* const each :
       {"pos26,nE,nW,crc6", "mt12,st20,nE,nW,lc6,crc16", "mt4,st8:gray,E,W,crc5",
        "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16"}) {
    const std::string capture = folder.path("values.csv");
    run_ok("simulate -f {} --clock 5MHz --motion random --cycles 4 -o {}", each, capture);
    const auto rows = rows_of(run("decode {} -f {} --to csv", capture, each).out);
    ASSERT_EQ(rows.size(), 4U);
    for (std::size_t n = 0; n < rows.size(); ++n) {
      const Outcome drawn =
          draw({capture, "-f", each, "--cycle", std::to_string(n), "--to", "svg"});
      const auto expect = [&](const std::string& name, const std::string& column) {
        EXPECT_THAT(drawn.out, HasSubstr(fmt::format(" {}={};", name, rows[n].at(column))));
      };
      const bool parted = std::string(each).starts_with("mt");
      if (!parted) expect("pos", "position");
      if (parted) expect("mt", "mt");
      if (parted) expect("st", "st");
      if (rows[n].contains("position2")) expect("pos.2", "position2");
      if (rows[n].contains("lc")) expect(rows[n].contains("position2") ? "lc.2" : "lc", "lc");
    }
  }
}

TEST_F(DrawVerb, CdmOfOne_IsDrawnUntilTheTimeout) {
  // MA stays low after the second frame until SLO has risen.
  std::string csv = "time_ns,MA,SLO\n-20000,1,1\n";
  const auto frame = [&csv](int begin, bool ends_low) {
    // LAT, ACK, START, CDS, 101, 011, STOP.
    const int slo[] = {1, 0, 1, 0, 1, 0, 1, 0, 1, 1, 0};
    int before = 1;
    for (int k = 0; k < 11; ++k) {
      csv += fmt::format("{},0,{}\n{},1,{}\n", begin + 1000 * k, before, begin + 1000 * k + 500,
                         slo[k]);
      before = slo[k];
    }
    const int end = begin + 11000;
    if (ends_low) csv += fmt::format("{},0,0\n", end);
    csv += fmt::format("{},{},1\n{},1,1\n", end + 2000, ends_low ? 0 : 1, end + 4000);
  };
  frame(1000, false);
  frame(20000, true);
  csv += "60000,1,1\n";
  const std::string capture = folder.file("cdm.csv", csv);
  EXPECT_THAT(draw({capture, "-f", "pos3,crc3"}).out, HasSubstr("CDM=0"));
  EXPECT_THAT(draw({capture, "-f", "pos3,crc3", "--cycle", "1"}).out, HasSubstr("CDM=1"));
}

TEST_F(DrawVerb, CycleOfACapture_AndSeveral) {
  const std::string capture = simulate(folder, "--fault flip@3");
  const Outcome one = ok(draw({capture, "-f", format, "--cycle", "3"}));
  EXPECT_THAT(one.out, HasSubstr("cycle 3 at"));
  EXPECT_THAT(one.out, HasSubstr("failure"));
  const Outcome several = draw({capture, "-f", format, "--cycle", "2", "--count", "3"});
  for (const char* const title : {"cycle 2 at", "cycle 3 at", "cycle 4 at"}) {
    EXPECT_THAT(several.out, HasSubstr(title));
  }
  const Outcome image = draw({capture, "-f", format, "--count", "6", "--to", "svg"});
  EXPECT_THAT(image.out, HasSubstr(">6 request cycles, from 0 on</title>"));
}

TEST_F(DrawVerb, CycleThatIsNotThere_IsNamedAndNothingIsWritten) {
  const std::string capture = simulate(folder);
  const std::string output = folder.path("cycle.svg");
  EXPECT_THAT(draw({capture, "-f", format, "--cycle", "6", "-o", output}),
              fails(1, "no cycle 6; the capture has 6 request cycles, counted from 0"));
  EXPECT_EQ(folder.files(), 1U);
  EXPECT_THAT(draw({capture, "-f", format, "--cycle", "4", "--count", "4"}),
              fails(1, "no cycle 6;"));
}

TEST_F(DrawVerb, DamagedFile_IsDrawnUpToTheDamage) {
  const std::string good = content_of(simulate(folder));
  const std::string capture =
      folder.file("damaged.csv", good.substr(0, good.size() / 2) + "\nnonsense\n");
  EXPECT_EQ(draw({capture, "-f", format, "--cycle", "0"}).status, 0);
  EXPECT_THAT(draw({capture, "-f", format, "--cycle", "5"}), refuses(3, "damaged.csv"));
}

TEST_F(DrawVerb, FileThatIsNotThere_IsAnErrorOfReading) {
  EXPECT_THAT(draw({"/nowhere/line.vcd", "-f", format}), fails(3, "/nowhere/line.vcd"));
}

TEST_F(DrawVerb, CaptureWithoutFormat_IsDrawnWithTheOneItShows) {
  const std::string capture = simulate(folder, "--motion random", "400");
  const Outcome outcome = ok(draw({capture, "--cycle", "2"}));
  EXPECT_THAT(outcome.err, HasSubstr("drawn with the format that its frames show"));
  EXPECT_THAT(outcome.out, HasSubstr("crc=0x"));
  const Outcome structure = draw({capture, "-f", "none", "--cycle", "2"});
  EXPECT_EQ(structure.err, "");
  EXPECT_THAT(structure.out, HasSubstr(" bits "));
}

TEST_F(DrawVerb, WrongUsage_IsOneLineThatSaysWhy) {
  const std::string capture = simulate(folder);
  const auto expect = [](const Words& words, const char* why) {
    EXPECT_THAT(draw(words), refuses(2, why));
  };
  expect({}, "no capture given; name a file, or give -f");
  expect({"-f", "none"}, "needs a format");
  expect({capture, "-f", format, "--clock", "1MHz"}, "--clock: describes a simulated line");
  expect({capture, "-f", format, "--no-compensation"},
         "--no-compensation: describes a simulated line");
  expect({"-f", format, "--invert-slo"}, "--invert-slo: describes a capture; name one");
  expect({"-f", format, "--each"}, "--each: describes a capture; name one");
  expect({"-f", format, "--resolution", "1ns"}, "--resolution: describes a capture; name one");
  expect({"-f", format, "--raw-rate", "1MHz"}, "--raw-rate: describes a capture; name one");
  expect({"-f", format, "--position", "4096"}, "--position: 0 to 4095");
  expect({"-f", "resolute-26", "--clock", "10MHz", "--ack", "3"},
         "--ack: this encoder answers after");
  expect({"-f", format, "--ack", "3", "--processing", "2us"}, "--processing");
  expect({"-f", format, "--width", "30"}, "--width: at least 60 columns");
  expect({"-f", format, "--to", "svg", "--width", "100"}, "--width: at least 480 pixels");
  expect({"-f", format, "--mark", "ready"}, "--mark: 'ready': give TIME=NAME");
  expect({"-f", format, "--count", "0"}, "--count: 1 to 100");
  expect({"-f", format, "--cycle", "1000000"}, "--cycle: a simulated line has 10000 cycles");
  expect({"-f", format, "--to", "png"}, "--to: 'png' is not one of text, svg");
}

TEST_F(DrawVerb, Mark_StandsAtItsTimeAndIsNotCutOut) {
  const Outcome outcome = ok(draw_line({"--mark", "30us=here", "--mark", "1s=nowhere"}));
  EXPECT_THAT(outcome.out, HasSubstr("marks "));
  EXPECT_THAT(outcome.out, HasSubstr("here"));
  EXPECT_THAT(outcome.out, Not(HasSubstr("nowhere")));
  EXPECT_THAT(outcome.err, HasSubstr("--mark: 1 s is not within the cycles drawn"));
  EXPECT_THAT(draw_line({"--mark", "5us=a<b&c", "--to", "svg"}).out, HasSubstr(">a&lt;b&amp;c<"));
}

// Edges without sense: the picture stays small, and every cycle is drawn.
TEST_F(DrawVerb, HostileCapture_IsDrawnInBoundedSpace) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::mt19937 random(seed);
    std::string csv = "time_ns,MA,SLO\n0,1,1\n";
    std::uint64_t time = 0;
    for (int i = 0; i < 20'000; ++i) {
      const auto draw_of = static_cast<unsigned>(random());
      const std::uint64_t step = seed % 2 == 0 ? 500 : 1 + draw_of % 997;
      time += draw_of % 4000 == 0 ? 3'600'000'000'000U / 8 : step;
      const unsigned ma = seed % 2 == 0 ? static_cast<unsigned>(i) % 2 : draw_of >> 8U & 1U;
      csv += fmt::format("{},{},{}\n", time, ma, draw_of >> 9U & 1U);
    }
    const std::string capture = folder.file("hostile.csv", csv);
    for (const char* const to : {"text", "svg"}) {
      const Outcome outcome =
          draw({capture, "-f", format, "--ma", "MA", "--slo", "SLO", "--to", to});
      ASSERT_LE(outcome.status, 1) << outcome.err;
      EXPECT_LT(outcome.out.size(), 2U << 20U);
      if (std::string(to) == "svg") folder.file(fmt::format("{}.svg", seed), outcome.out);
    }
  }
  EXPECT_TRUE(all_well_formed(folder.path("")));
}

}  // namespace biss::verbs::draw_test
