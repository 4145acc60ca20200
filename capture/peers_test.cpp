// Capture files of this project in other programs, and theirs in its readers. scripts/packages.txt
// lists the packages. Where they are missing, the tests report themselves as skipped.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "capture/open.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/test_peers.hpp"
#include "capture/test_samples.hpp"
#include "capture/vcd.hpp"

namespace biss::capture {
namespace peers_test {

struct Lines {
  std::vector<std::string> names;
  std::vector<wire::Edge> edges;
  Picoseconds end;
};

constexpr Hertz rate = megahertz(100);

// Edges at sample times: bursts as of request cycles, long idle times between them, more than one
// chunk.
Lines bursts(std::size_t count, unsigned longest_idle = 200'000) {
  Lines lines;
  for (std::size_t i = 0; i < count; ++i) lines.names.push_back("L" + std::to_string(i));
  lines.names[0] = "MA";
  std::mt19937_64 random(7'407);
  for (std::size_t i = 0; i < count; ++i) {
    lines.edges.push_back({{}, static_cast<wire::LineIndex>(i), wire::Level::high});
  }
  std::vector<bool> high(count, true);
  Picoseconds now{};
  for (int burst = 0; burst < 60; ++burst) {
    now += nanoseconds(10) * static_cast<std::int64_t>(1 + random() % longest_idle);
    for (int i = 0; i < 100; ++i) {
      now += nanoseconds(10) * static_cast<std::int64_t>(1 + random() % 9);
      const std::size_t line = random() % count;
      high[line] = !high[line];
      lines.edges.push_back({now, static_cast<wire::LineIndex>(line),
                             high[line] ? wire::Level::high : wire::Level::low});
    }
  }
  lines.end = now + microseconds(1);
  return lines;
}

// `arguments` come before the sink.
template <class Writer, class... Arguments>
std::string written(const Lines& lines, const Arguments&... arguments) {
  std::string bytes;
  StringSink sink(bytes);
  Writer writer(arguments..., sink);
  EXPECT_TRUE(writer.write(lines.edges).ok());
  EXPECT_TRUE(writer.finish(lines.end).ok());
  return bytes;
}

// An FST keeps no order among the changes with the same time.
std::vector<wire::Edge> by_line(std::vector<wire::Edge> edges) {
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.line < b.line; });
  return edges;
}

constexpr const char* no_sigrok = "no sigrok-cli: scripts/install-packages test";

class Sigrok : public testing::TestWithParam<std::size_t> {
 protected:
  void SetUp() override {
    if (!runs("sigrok-cli --version")) GTEST_SKIP() << no_sigrok;
    lines_ = bursts(GetParam());
    folder_.file("ours.sr", written<SrWriter>(lines_, lines_.names, rate));
  }

  // The session converted by sigrok-cli to that format.
  std::string theirs(const std::string& format, const std::string& name) const {
    const std::string path = folder_.path(name);
    EXPECT_TRUE(runs("sigrok-cli -i " + folder_.path("ours.sr") + " -O " + format + " -o " + path));
    return path;
  }

  Folder folder_;
  Lines lines_;
};

TEST_P(Sigrok, OurSession_HasTheSameLevelsThere) {
  const std::string samples = content_of(theirs("binary", "theirs.bin"));
  const std::string ours = written<RawWriter>(lines_, packed_layout(lines_.names, rate));
  EXPECT_EQ(samples.size(), ours.size());
  EXPECT_TRUE(samples == ours);
}

TEST_P(Sigrok, SessionItWroteFromOurs_HasTheSameEdges) {
  const Read read = read_all(open_capture(theirs("srzip", "theirs.sr")));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, lines_.names);
  EXPECT_EQ(read.edges, lines_.edges);
  EXPECT_EQ(read.end_time, lines_.end);
}

TEST_P(Sigrok, VcdItWroteFromOurs_HasTheSameEdges) {
  const Read read = read_all(open_capture(theirs("vcd", "theirs.vcd")));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, lines_.names);
  EXPECT_EQ(read.edges, lines_.edges);
}

// Without times the first sample is at 0, with times one period later.
TEST(SigrokCsv, CsvItWroteFromOurSession_HasTheSameEdges) {
  if (!runs("sigrok-cli --version")) GTEST_SKIP() << no_sigrok;
  const Folder folder;
  const Lines lines = bursts(3, 100);
  folder.file("ours.sr", written<SrWriter>(lines, lines.names, rate));
  for (const std::string format :
       {"csv", "csv:label=channel", "csv:time=true", "csv:time=true:label=channel:dedup=true"}) {
    SCOPED_TRACE(format);
    ASSERT_TRUE(runs("sigrok-cli -i " + folder.path("ours.sr") + " -O " + format + " -o " +
                     folder.path("theirs.csv")));
    const Read read = read_all(open_capture(folder.path("theirs.csv")));
    EXPECT_FALSE(read.error);
    EXPECT_EQ(read.lines, lines.names);
    std::vector<wire::Edge> expected = lines.edges;
    for (wire::Edge& edge : expected) {
      edge.time += nanoseconds(format.find("time") != std::string::npos ? 10 : 0);
    }
    EXPECT_EQ(read.edges, expected);
  }
}

TEST(SigrokAnalog, CsvOfItsDemoDevice_HasItsSquareWave) {
  if (!runs("sigrok-cli --version")) GTEST_SKIP() << no_sigrok;
  const Folder folder;
  const std::string path = folder.path("demo.csv");
  ASSERT_TRUE(
      runs("sigrok-cli -d demo:analog_channels=2:logic_channels=1 --samples 20000 --config "
           "samplerate=1m -O csv -o " +
           path));
  const Read read = read_all(open_capture(path));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.lines, (std::vector<std::string>{"D0", "A0", "A1"}));
  // One channel is a square wave, one a sine, of ten samples a period and up; both cross 0 V.
  for (const wire::LineIndex line : {1U, 2U}) {
    const auto changes =
        std::count_if(read.edges.begin(), read.edges.end(),
                      [line](const wire::Edge& edge) { return edge.line == line; });
    EXPECT_GT(changes, 100) << line;
  }
}

INSTANTIATE_TEST_SUITE_P(Lines, Sigrok, testing::Values(2, 9, 32));

TEST(Gtkwave, OurVcd_BecomesAnFstWithTheSameEdges) {
  // Without arguments both print their usage and fail.
  if (!runs("command -v vcd2fst") || !runs("command -v fst2vcd")) {
    GTEST_SKIP() << "no vcd2fst: scripts/install-packages test";
  }
  const Folder folder;
  Lines lines = bursts(3);
  lines.edges.insert(lines.edges.begin() + 50, {lines.edges[49].time, 2, wire::Level::unknown});
  folder.file("ours.vcd", written<VcdWriter>(lines, lines.names));
  ASSERT_TRUE(runs("vcd2fst " + folder.path("ours.vcd") + " " + folder.path("theirs.fst")));
  ASSERT_TRUE(runs("fst2vcd -f " + folder.path("theirs.fst") + " -o " + folder.path("back.vcd")));
  const Read ours = read_all(open_capture(folder.path("ours.vcd")));
  const Read back = read_all(open_capture(folder.path("back.vcd")));
  EXPECT_FALSE(back.error);
  EXPECT_EQ(back.lines, ours.lines);
  EXPECT_EQ(by_line(back.edges), by_line(ours.edges));
}

class Vcd2fst : public testing::TestWithParam<const char*> {};

TEST_P(Vcd2fst, OurVcd_BecomesAnFstThatWeReadTheSame) {
  if (!runs("command -v vcd2fst")) GTEST_SKIP() << "no vcd2fst: scripts/install-packages test";
  const Folder folder;
  Lines lines = bursts(5);
  lines.edges.insert(lines.edges.begin() + 50, {lines.edges[49].time, 2, wire::Level::unknown});
  folder.file("ours.vcd", written<VcdWriter>(lines, lines.names));
  ASSERT_TRUE(runs("vcd2fst " + std::string(GetParam()) + " " + folder.path("ours.vcd") + " " +
                   folder.path("theirs.fst")));
  const Read ours = read_all(open_capture(folder.path("ours.vcd")));
  const Read theirs = read_all(open_capture(folder.path("theirs.fst")));
  EXPECT_FALSE(theirs.error);
  EXPECT_EQ(theirs.lines, ours.lines);
  EXPECT_TRUE(by_line(theirs.edges) == by_line(ours.edges));
  EXPECT_EQ(theirs.end_time, ours.end_time);
}

INSTANTIATE_TEST_SUITE_P(Packings, Vcd2fst,
                         testing::Values("-4", "-F", "-Z", "-4 -c", "-F -c", "-Z -c", "-p"));

constexpr const char* verilog = R"(`timescale 1ns/1ps
module encoder(input wire ma, output reg slo);
  reg [11:0] position = 12'ha5c;
  integer n = 0;
  initial slo = 1'b1;
  always @(posedge ma) begin n = n + 1; slo <= #20 position[n % 12]; end
endmodule
module tb;
  reg MA; wire SLO; reg floats; reg [7:0] bus; real r; wire [3:0] pins;
  assign pins = {MA, 3'b0};
  encoder dut(.ma(MA), .slo(SLO));
  integer i;
  initial begin
    $dumpfile("wave"); $dumpvars(0, tb);
    MA = 1; bus = 0; r = 0.5; floats = 1'bz; #1000;
    for (i = 0; i < 300; i = i + 1) begin
      MA = 0; #50.5; MA = 1; bus = bus + 1; r = r + 2; if (i % 7 == 0) floats = i; #49.5;
    end
    #500; $dumpoff; #333; MA = 0; #100 MA = 1; #100 $dumpon; #3000;
    for (i = 0; i < 300; i = i + 1) begin MA = 0; #50; MA = 1; #50; end
    $finish;
  end
endmodule
)";

TEST(Icarus, FstOfARun_HasTheEdgesOfItsVcd) {
  if (!runs("iverilog -V")) GTEST_SKIP() << "no iverilog: scripts/install-packages test";
  const Folder folder;
  folder.file("tb.v", verilog);
  const std::string run = "cd " + folder.path(".") + " && vvp tb -";
  ASSERT_TRUE(runs("iverilog -g2012 -o " + folder.path("tb") + " " + folder.path("tb.v")));
  ASSERT_TRUE(runs(run + "vcd"));
  for (const char* format : {"fst", "fst-space"}) {
    ASSERT_TRUE(runs(run + format));
    EXPECT_EQ(changes_of(folder.path("wave.fst")), changes_of(folder.path("wave.vcd"))) << format;
  }
  EXPECT_GT(changes_of(folder.path("wave.fst"))["SLO"].size(), 200U);
}

constexpr const char* vhdl = R"(library ieee;
use ieee.std_logic_1164.all;
entity encoder is port (ma_in : in std_logic; slo_out : out std_logic); end;
architecture rtl of encoder is
  signal count : integer := 0;
  signal odd : boolean := false;
  constant frame : std_logic_vector(0 to 11) := "001011010011";
begin
  process (ma_in) begin
    if rising_edge(ma_in) then
      slo_out <= frame(count mod 12) after 20 ns;
      count <= count + 1;
      odd <= not odd;
    end if;
  end process;
end;
library ieee;
use ieee.std_logic_1164.all;
entity tb is end;
architecture sim of tb is
  type open_pair is record a : std_logic; v : std_logic_vector; end record;
  type state is (idle, run, stop);
  type grid is array (natural range <>, natural range <>) of bit;
  type rows is array (natural range <>) of std_logic_vector;
  signal ma : std_logic := '1';
  signal slo : std_logic;
  signal b : bit;
  signal early : bit;
  signal levels : std_ulogic := 'Z';
  signal pins : std_logic_vector(7 downto 0) := x"00";
  signal memory : rows(0 to 15)(7 downto 0);
  signal both : open_pair(v(1 downto 0));
  signal now_in : state;
  signal r : real := 0.5;
  signal t : time := 1 ns;
  signal g : grid(0 to 1, 2 downto 1);
begin
  early <= '1';
  dut : entity work.encoder port map (ma_in => ma, slo_out => slo);
  lanes : for i in 0 to 1 generate signal lane : std_logic := 'H'; begin lane <= ma; end generate;
  process begin
    wait for 1 us;
    for i in 0 to 299 loop
      ma <= '0'; b <= not b; pins(3) <= ma; wait for 50500 ps;
      ma <= '1'; both.v(0) <= ma; now_in <= run; r <= r + 2.0; t <= t + 3 ns; g(1, 1) <= not g(1, 1);
      memory(i mod 16)(3) <= ma; wait for 49500 ps;
    end loop;
    for level in std_ulogic loop levels <= level; wait for 7 ns; end loop;
    wait;
  end process;
end;
)";

TEST(Ghdl, FstOfARun_HasTheEdgesOfItsVcd) {
  if (!runs("ghdl --version")) GTEST_SKIP() << "no ghdl: scripts/install-packages test";
  const Folder folder;
  folder.file("tb.vhdl", vhdl);
  const std::string in_folder = "cd " + folder.path(".") + " && ghdl -";
  ASSERT_TRUE(runs(in_folder + "a --std=08 tb.vhdl"));
  ASSERT_TRUE(runs(in_folder + "r --std=08 tb --vcd=a.vcd --fst=a.fst"));
  const Changes vcd = changes_of(folder.path("a.vcd"));
  EXPECT_GT(vcd.at("slo").size(), 100U);
  EXPECT_EQ(changes_of(folder.path("a.fst")), vcd);
}

}  // namespace peers_test
}  // namespace biss::capture
