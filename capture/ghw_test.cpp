#include "capture/ghw.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_ghw.hpp"

namespace biss::capture {
namespace ghw_test {

using testing::ElementsAre;
using testing::HasSubstr;
using namespace std::string_literals;
using namespace std::string_view_literals;

Read read_ghw(std::string_view bytes, std::size_t block = one_block) {
  return read_all(open_ghw(memory_bytes(bytes, block)));
}

std::string text_of(const Read& read) {
  return read.error ? capture_error_text(*read.error, "a.ghw") : "";
}

const std::vector<std::string> ma_slo{"ma", "slo"};

std::vector<wire::Edge> some_edges() {
  return {edge(0, 0, '1'), edge(100, 0, '0'), edge(100, 1, '1'), edge(150, 0, '1'),
          edge(9'000'000'000, 1, '0')};
}

// The snapshot at the begin has no level; what changes at its time has the new one only.
std::vector<wire::Edge> edges_of_some() {
  std::vector<wire::Edge> edges = some_edges();
  edges.insert(edges.begin() + 1, edge(0, 1, 'x'));
  return edges;
}

TEST(Ghw, Cycles_BecomeEdges) {
  for (const unsigned version : {0U, 1U}) {
    for (const bool big_endian : {false, true}) {
      const std::string file = ghw_of(ma_slo, some_edges(), version, big_endian);
      for (const std::size_t block : {std::size_t{1}, one_block}) {
        const Read read = read_ghw(file, block);
        EXPECT_EQ(text_of(read), "");
        EXPECT_EQ(read.lines, ma_slo);
        EXPECT_EQ(read.edges, edges_of_some());
        EXPECT_EQ(read.end_time, milliseconds(9));
      }
    }
  }
}

// `types` and `hierarchy` with their counts; strings are numbered from 1. One snapshot of `values`.
std::string file_of(const std::vector<std::string>& strings, unsigned types,
                    std::string_view type_bytes, unsigned signal_count, std::string_view hierarchy,
                    std::string_view values) {
  GhwText text = ghw_start();
  text.strings(strings);
  text.section("TYP");
  text.word(types);
  text.put(type_bytes);
  text.byte(0);
  text.section("HIE");
  for (const unsigned count : {1U, 1U, signal_count}) text.word(count);
  text.put(hierarchy);
  text.put("\0EOH\0SNP\0\0\0\0\0"sv);
  text.time(0);
  text.put(values);
  text.put("ESN\0TAI\0\0\0\0\0\0\0\0\0"sv);
  return text.text();
}

TEST(Ghw, BitAndBoolean_AreLines) {
  // bit is an enumeration of two values; so are boolean and a state, which has no level.
  const Read read = read_ghw(file_of({"'0'", "'1'", "false", "true", "idle", "run", "b", "f", "s"},
                                     3, "\x16\7\2\1\2\x16\7\2\3\4\x17\7\2\5\6"sv, 3,
                                     "\x10\7\1\1\x10\x08\2\2\x10\x09\3\3"sv, "\1\0\1"sv));
  EXPECT_EQ(text_of(read), "");
  EXPECT_THAT(read.lines, ElementsAre("b", "f"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '0')));
}

TEST(Ghw, EveryValueOfStdUlogic_IsTheLevelThatVcdHas) {
  std::vector<std::string> strings = ghw_levels;
  strings.push_back("x");
  std::string hierarchy;
  for (char i = 1; i <= 9; ++i) hierarchy += std::string("\x10\x0A\1", 3) + i;
  const Read read = read_ghw(file_of(strings, 1, "\x17\x0A\x09\1\2\3\4\5\6\7\x08\x09"sv, 9,
                                     hierarchy, "\0\1\2\3\4\5\6\7\x08"sv));
  std::string levels;
  for (const wire::Edge& e : read.edges) levels += "01x"[static_cast<std::size_t>(e.level)];
  EXPECT_EQ(levels, "xx01xx01x");
}

// Types: 1 bit, 2 integer, 3 array of bit, 4 its subtype (3 downto 2), 5 record of 1 and 4.
constexpr std::string_view composite_types =
    "\x16\3\2\1\2\x19\4\x1F\5\1\1\2\x23\5\3\x99\3\2\x20\6\2\7\1\x08\4"sv;
const std::vector<std::string> composite_strings{"'0'", "'1'", "bit", "int",  "vec",
                                                 "rec", "a",   "v",   "pins", "sum"};

TEST(Ghw, ElementsOfArraysAndRecords_AreLines) {
  const Read read =
      read_ghw(file_of(composite_strings, 5, composite_types, 6,
                       "\x10\x09\4\1\2\x10\x0A\2\3\x10\6\5\4\5\6"sv, "\1\0\x7F\0\1\1"sv));
  EXPECT_EQ(text_of(read), "");
  EXPECT_THAT(read.lines, ElementsAre("pins(3)", "pins(2)", "rec.a", "rec.v(3)", "rec.v(2)"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '0'), edge(0, 2, '0'),
                                      edge(0, 3, '1'), edge(0, 4, '1')));
}

TEST(Ghw, LargeArrays_AreSkipped) {
  const std::string types = std::string(composite_types.substr(0, 12)) + "\x23\5\3\x19"s + '\0' +
                            std::string(1, '\x3F') + "\x23\5\3\x19"s + '\0' + "\xC0"s + '\0';
  std::string signals;
  for (char i = 1; i <= 64; ++i) signals += i;
  std::string more_signals;
  for (unsigned i = 65; i <= 129; ++i) {
    if (i < 128) more_signals += static_cast<char>(i);
    if (i >= 128) more_signals += {static_cast<char>(i), '\1'};
  }
  const Read read = read_ghw(file_of(composite_strings, 5, types, 129,
                                     "\x10\x09\4"s + signals + "\x10\x0A\5"s + more_signals,
                                     std::string(129, '\1')));
  EXPECT_EQ(text_of(read), "");
  ASSERT_EQ(read.lines.size(), 64U);
  EXPECT_EQ(read.lines[63], "pins(63)");
}

TEST(Ghw, SharedSignal_IsOneLineForEachName) {
  const Read read =
      read_ghw(file_of({"'0'", "'1'", "bit", "tb", "ma", "dut", "clk"}, 1, "\x16\3\2\1\2"sv, 1,
                       "\6\4\x10\5\1\1\6\6\x11\5\1\1\x11\7\1\1\x0D\3\x0F\x0F"sv, "\1"sv));
  EXPECT_EQ(text_of(read), "");
  EXPECT_THAT(read.lines, ElementsAre("ma", "clk"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '1')));
}

TEST(Ghw, Generates_HaveTheirNumber) {
  const Read read =
      read_ghw(file_of({"'0'", "'1'", "bit", "int", "g", "x"}, 2, "\x16\3\2\1\2\x19\4"sv, 2,
                       "\5\5\2\x7F\x10\6\1\1\x0F\5\5\2\3\x10\6\1\2\x0F"sv, "\1\0"sv));
  EXPECT_EQ(text_of(read), "");
  EXPECT_THAT(read.lines, ElementsAre("g(-1).x", "g(3).x"));
}

// Strings share letters with the one before, more than 31 of them too; letters are Latin-1.
TEST(Ghw, Strings_ShareTheirBeginnings) {
  const std::string long_name(40, 'n');
  GhwText text = ghw_start();
  text.section("STR");
  text.word(5);
  text.word(0);
  text.put(
      "'0'\1"
      "1'\0"
      "bit\0"sv);
  text.put(long_name +
           "\x88\1"
           "\xE9\0"
           "EOS\0"s);
  text.section("TYP");
  text.word(1);
  text.put("\x16\3\2\1\2\0"sv);
  text.section("HIE");
  for (int i = 0; i < 3; ++i) text.word(2);
  text.put("\x10\4\1\1\x10\5\1\2\0EOH\0"sv);
  EXPECT_THAT(read_ghw(text.text()).lines, ElementsAre(long_name, long_name + "\xC3\xA9"));
}

TEST(Ghw, TruncatedFile_KeepsWhatCameBefore) {
  const std::string file = ghw_of(ma_slo, some_edges());
  const std::size_t values = file.find("SNP");
  std::size_t most = 0;
  for (std::size_t size = 1; size < file.size(); ++size) {
    const Read read = read_ghw(file.substr(0, size));
    EXPECT_EQ(read.cause(), CaptureCause::truncated) << size;
    EXPECT_GE(read.edges.size(), most);
    most = read.edges.size();
    if (size > values) {
      EXPECT_EQ(read.lines, ma_slo);
    }
  }
  EXPECT_EQ(most, 6U);
  EXPECT_THAT(text_of(read_ghw(file.substr(0, file.size() - 1))),
              HasSubstr("let GHDL finish the simulation"));
}

TEST(Ghw, WrongTimes_AreNamed) {
  std::string file = ghw_of(ma_slo, {});
  const std::size_t cycle = file.find("CYC");
  EXPECT_EQ(read_ghw(file.substr(0, cycle + 11) + "\x80").cause(), CaptureCause::time_out_of_range);
  EXPECT_EQ(read_ghw(file.substr(0, cycle + 12) + "\0\x7E"s).cause(), CaptureCause::time_backwards);
  file[cycle - 20] = 1;  // the time of the snapshot: after the cycle
  EXPECT_EQ(read_ghw(file).cause(), CaptureCause::malformed);
}

TEST(Ghw, WrongHeaders_AreNamed) {
  const auto text_with = [](unsigned types, std::string_view type_bytes,
                            std::string_view hierarchy) {
    const Read read = read_ghw(file_of(composite_strings, types, type_bytes, 6, hierarchy, "\0\0"));
    EXPECT_EQ(read.cause(), CaptureCause::malformed);
    return text_of(read);
  };
  EXPECT_THAT(text_with(1, "\x63\1"sv, ""), HasSubstr("a.ghw: the types"));
  EXPECT_THAT(text_with(1, "\x16\3\2\1\x0C"sv, ""), HasSubstr("number of a string"));
  EXPECT_THAT(text_with(1, "\x23\3\1"sv, ""), HasSubstr("an earlier type"));
  EXPECT_THAT(text_with(5, composite_types, "\x10\1\3\1"sv), HasSubstr("a type with bounds"));
  EXPECT_THAT(text_with(5, composite_types, "\x10\1\1\7"sv), HasSubstr("number of a signal"));
  EXPECT_THAT(text_with(5, composite_types, "\x0F"sv), HasSubstr("a scope for each"));
  EXPECT_THAT(text_with(5, composite_types, "\x09\1"sv), HasSubstr("a scope or a signal"));
  std::string file = ghw_of(ma_slo, {});
  file[11] = 2;
  EXPECT_THAT(text_of(read_ghw(file)), HasSubstr("version 0 or 1"));
}

TEST(Ghw, Content_IsRecognised) {
  const std::string file = ghw_of(ma_slo, some_edges());
  for (const char* path : {"a.ghw", "a.vcd", "-"}) {
    EXPECT_FALSE(read_all(open_capture(memory_bytes(file, 1), path)).error) << path;
  }
  EXPECT_EQ(read_all(open_capture(memory_bytes("other"), "a.ghw")).cause(),
            CaptureCause::malformed);
}

}  // namespace ghw_test
}  // namespace biss::capture
