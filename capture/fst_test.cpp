#include "capture/fst.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_compressed.hpp"
#include "capture/test_fst.hpp"

namespace biss::capture {
namespace fst_test {

using testing::ElementsAre;
using testing::HasSubstr;

Read read_fst(const std::string& bytes, std::size_t block = one_block) {
  return read_all(open_fst(memory_bytes(bytes, block)));
}

std::string text_of(const Read& read) {
  return read.error ? capture_error_text(*read.error, "a.fst") : "";
}

const std::vector<std::string> ma_slo{"MA", "SLO"};

std::vector<wire::Edge> some_edges() {
  return {edge(0, 0, '1'),   edge(0, 1, '1'),           edge(100, 0, '0'),        edge(150, 0, '1'),
          edge(150, 1, '0'), edge(150'000'000, 1, 'x'), edge(150'000'001, 1, '1')};
}

// Edges with the same time come by line.
std::vector<wire::Edge> random_edges(std::size_t lines, std::size_t count) {
  std::mt19937_64 random(4'711);
  std::vector<wire::Edge> edges;
  std::vector<char> levels(lines, '?');
  std::int64_t now = 0;
  for (std::size_t i = 0; i < count; ++i) {
    now += static_cast<std::int64_t>(1 + random() % (random() % 5 == 0 ? 100'000 : 90));
    const std::size_t first = random() % lines;
    for (std::size_t line = first; line < lines; line += 1 + random() % lines) {
      const char level = "01x"[random() % 3];
      if (level == levels[line]) continue;
      levels[line] = level;
      edges.push_back(edge(now, static_cast<wire::LineIndex>(line), level));
    }
  }
  return edges;
}

TEST(Fst, ChainsOfSignals_BecomeEdgesInTheOrderOfTime) {
  const std::string file = fst_of(fst_parts_of(ma_slo, some_edges()));
  for (const std::size_t block : {std::size_t{1}, one_block}) {
    const Read read = read_fst(file, block);
    EXPECT_EQ(text_of(read), "");
    EXPECT_EQ(read.lines, ma_slo);
    EXPECT_EQ(read.edges, some_edges());
    EXPECT_EQ(read.end_time, picoseconds(150'000'001));
  }
}

// A file as a whole in gzip, which says that it has `size` bytes.
std::string wrapped(const std::string& packed, std::uint64_t size) {
  std::string bytes(1, static_cast<char>(254));
  put_big_endian(bytes, packed.size() + 16);
  put_big_endian(bytes, size);
  return bytes + packed;
}

TEST(Fst, FileInGzip_IsReadAsTheFile) {
  const std::string file = fst_of(fst_parts_of(ma_slo, some_edges()));
  const std::string bytes = wrapped(gzip_of(file), file.size());
  for (const std::string& text : {bytes, gzip_of(bytes), gzip_of(file), zstd_of(file)}) {
    for (const std::size_t block : {std::size_t{1}, one_block}) {
      const Read read = read_all(open_capture(memory_bytes(text, block), "a"));
      EXPECT_EQ(text_of(read), "");
      EXPECT_EQ(read.edges, some_edges());
    }
  }
}

TEST(Fst, DamagedWrapper_IsNamed) {
  const std::string file = fst_of(fst_parts_of(ma_slo, some_edges()));
  const std::string packed = gzip_of(file);
  const auto cause = [](const std::string& bytes) { return read_fst(bytes).cause(); };
  EXPECT_EQ(cause(wrapped(packed, file.size() - 1)), CaptureCause::damaged);
  EXPECT_EQ(cause(wrapped(packed, file.size() + 1)), CaptureCause::damaged);
  EXPECT_EQ(cause(wrapped(packed, std::uint64_t{1} << 40U)), CaptureCause::damaged);
  EXPECT_EQ(cause(wrapped(packed.substr(0, packed.size() - 9), file.size())),
            CaptureCause::damaged);
  std::string changed = packed;
  changed.back() ^= 1;
  EXPECT_EQ(cause(wrapped(changed, file.size())), CaptureCause::damaged);
}

TEST(Fst, ManyLinesAndChanges_AreMerged) {
  std::vector<std::string> names;
  for (int i = 0; i < 40; ++i) names.push_back("line" + std::to_string(i));
  const std::vector<wire::Edge> edges = random_edges(names.size(), 5'000);
  FstParts parts = fst_parts_of(names, edges);
  parts.blocks[0].begin = static_cast<std::uint64_t>(edges[0].time.count);
  const Read read = read_fst(fst_of(parts));
  EXPECT_EQ(text_of(read), "");
  EXPECT_TRUE(read.edges == edges);
}

TEST(Fst, SeveralBlocks_AreReadOneAfterTheOther) {
  FstParts parts = fst_parts_of(ma_slo, {edge(5, 0, '1'), edge(9, 0, '0')});
  parts.blocks.push_back(fst_block_of({edge(9, 1, '1'), edge(12, 0, '1')}, 2, 9));
  parts.blocks[1].frame = "00";
  const Read read = read_fst(fst_of(parts));
  EXPECT_EQ(text_of(read), "");
  // The first block begins at 0, before its changes: its initial values count.
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, 'x'), edge(0, 1, 'x'), edge(5, 0, '1'),
                                      edge(9, 0, '0'), edge(9, 1, '1'), edge(12, 0, '1')));
  parts.blocks[1] = fst_block_of({edge(8, 1, '1')}, 2, 8);
  EXPECT_EQ(read_fst(fst_of(parts)).cause(), CaptureCause::time_backwards);
}

TEST(Fst, InitialValues_AreLevelsFromTheBeginning) {
  FstParts parts = fst_parts_of(ma_slo, {edge(0, 0, '0'), edge(7, 1, '0')});
  parts.blocks[0].frame = "x1";
  EXPECT_THAT(read_fst(fst_of(parts)).edges,
              ElementsAre(edge(0, 1, '1'), edge(0, 0, '0'), edge(7, 1, '0')));
}

TEST(Fst, EveryLetter_IsTheLevelThatVcdHas) {
  // A rare value is a number and not a letter: x z h u w l - ?
  FstParts parts = fst_parts_of({"MA"}, {edge(0, 0, '1')});
  FstPartsBlock& block = parts.blocks[0];
  block.chains = std::string("\0", 1);
  block.times.clear();
  for (unsigned value = 0; value < 8; ++value) {
    put_varint(block.chains, (value == 0 ? 0U : 1U) << 4U | value << 1U | 1U);
    put_varint(block.chains, 1U << 2U | (value % 2 != 0 ? 2U : 0U));  // between two of them
    put_varint(block.times, value == 0 ? 0 : 1);
    put_varint(block.times, 1);
  }
  block.times_count = 16;
  std::string levels;
  for (const wire::Edge& e : read_fst(fst_of(parts)).edges) {
    levels += "01x"[static_cast<std::size_t>(e.level)];
  }
  EXPECT_EQ(levels, "x0x10x1x01x0x1");
}

TEST(Fst, TimeScale_IsExact) {
  const auto end_at = [](std::int8_t exponent, std::int64_t ticks) {
    FstParts parts = fst_parts_of({"MA"}, {edge(ticks, 0, '1')});
    parts.exponent = exponent;
    return read_fst(fst_of(parts));
  };
  EXPECT_EQ(end_at(-9, 7).end_time, nanoseconds(7));
  EXPECT_EQ(end_at(-10, 7).end_time, picoseconds(700));
  EXPECT_EQ(end_at(2, 1).end_time.count, 100'000'000'000'000);
  EXPECT_EQ(end_at(-15, 1'499).end_time, picoseconds(1));
  EXPECT_EQ(end_at(-15, 1'500).end_time, picoseconds(2));
  EXPECT_EQ(end_at(-18, 2'500'000).end_time, picoseconds(3));
  EXPECT_EQ(end_at(2, 92'233'720).cause(), CaptureCause::time_out_of_range);
  EXPECT_EQ(end_at(3, 0).cause(), CaptureCause::malformed);
}

TEST(Fst, Aliases_AreOtherNamesOrTheSameLine) {
  FstParts parts = fst_parts_of(ma_slo, some_edges());
  parts.hierarchy.pop_back();
  parts.hierarchy += std::string("\xFE\0dut\0\0", 7) + fst_variable("ma_in", 1) +
                     fst_variable("SLO", 2) + "\xFF\xFF";
  const Read read = read_fst(fst_of(parts));
  EXPECT_THAT(read.lines, ElementsAre("MA", "SLO", "ma_in"));
  EXPECT_EQ(std::count_if(read.edges.begin(), read.edges.end(),
                          [](const wire::Edge& e) { return e.line == 2; }),
            3);
}

// Chains that are equal are stored once, in each way of writing the index.
TEST(Fst, EqualChains_AreSharedInTheIndex) {
  FstParts parts = fst_parts_of({"a", "b", "c", "d"}, {edge(0, 1, '1'), edge(3, 1, '0')});
  const std::string plain("\2\3\0\2\0\2", 6);    // none, a chain, aliases of handle 2
  const std::string with_sign("\2\3\x7D\1", 4);  // …, −2: of handle 2, and the same again
  for (const auto& [kind, index] : {std::pair{5, plain}, std::pair{8, with_sign}}) {
    parts.blocks[0].kind = static_cast<std::uint8_t>(kind);
    parts.blocks[0].index = index;
    const Read read = read_fst(fst_of(parts));
    EXPECT_EQ(text_of(read), "") << kind;
    EXPECT_THAT(read.edges, ElementsAre(edge(0, 1, '1'), edge(0, 2, '1'), edge(0, 3, '1'),
                                        edge(3, 1, '0'), edge(3, 2, '0'), edge(3, 3, '0')))
        << kind;
  }
  parts.blocks[0].index = "\3\x7B\1";  // −3: a later handle
  EXPECT_EQ(read_fst(fst_of(parts)).cause(), CaptureCause::damaged);
}

TEST(Fst, OtherVariables_AreSkipped) {
  FstParts parts = fst_parts_of({"bus", "MA"}, {edge(0, 1, '1')});
  parts.geometry[0] = 8;
  parts.blocks[0].frame = std::string(9, 'x');
  parts.hierarchy = std::string("\x10\0bus [7:0]\0\x08\0", 14) + fst_variable("MA [3]") +
                    std::string("\1\0n\0\1\2", 6);
  const Read read = read_fst(fst_of(parts));
  EXPECT_EQ(text_of(read), "");
  EXPECT_THAT(read.lines, ElementsAre("MA[3]"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1')));
}

TEST(Fst, WhileDumpingIsOff_LevelsAreUnknown) {
  FstParts parts = fst_parts_of(ma_slo, {edge(0, 0, '1'), edge(0, 1, '1'), edge(10, 0, '0'),
                                         edge(20, 0, '1'), edge(30, 0, '0'), edge(40, 1, '0')});
  parts.blackouts = std::string("\2\0\x0F\1\x0F", 5);  // off at 15, on at 30
  EXPECT_THAT(read_fst(fst_of(parts)).edges,
              ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(10, 0, '0'), edge(15, 0, 'x'),
                          edge(15, 1, 'x'), edge(30, 0, '0'), edge(30, 1, '1'), edge(40, 1, '0')));
  parts.blackouts = std::string("\1\0\x28", 3);  // off at the end
  EXPECT_EQ(read_fst(fst_of(parts)).edges.back(), edge(40, 1, 'x'));
  parts.blackouts = "\2";
  EXPECT_EQ(read_fst(fst_of(parts)).cause(), CaptureCause::damaged);
}

TEST(Fst, UnfinishedFile_SaysThatTheNamesAreMissing) {
  const std::string file = fst_of(fst_parts_of(ma_slo, some_edges()));
  for (std::size_t size = 400; size < file.size(); size += 13) {
    const Read read = read_fst(file.substr(0, size));
    EXPECT_EQ(read.cause(), CaptureCause::truncated) << size;
    EXPECT_THAT(text_of(read), HasSubstr("let the simulator finish")) << size;
  }
}

TEST(Fst, PartsThatAreNotKnown_AreNamed) {
  FstParts parts = fst_parts_of(ma_slo, some_edges());
  parts.blocks.push_back(fst_block_of({edge(150'000'002, 0, '0')}, 2, 150'000'001));
  const std::string good = fst_of(parts);
  EXPECT_FALSE(read_fst(good).error);
  parts.blocks[1].kind = 9;
  EXPECT_EQ(read_fst(fst_of(parts)).cause(), CaptureCause::malformed);
  EXPECT_TRUE(read_fst(good + fst_hierarchy(fst_variable("MA"))).error);
  EXPECT_TRUE(read_fst(good + "rest").error);
  EXPECT_TRUE(read_fst(good + std::string(40, '\0')).error);
  EXPECT_TRUE(read_fst(good + fst_block(parts.blocks[1]).substr(0, 30)).error);
}

TEST(Fst, DamagedBlock_LosesOnlyWhatFollows) {
  FstParts parts = fst_parts_of(ma_slo, some_edges());
  parts.blocks.push_back(fst_block_of({edge(150'000'002, 0, '0')}, 2, 150'000'001));
  const auto damage = [&](auto change) {
    FstParts damaged = parts;
    change(damaged.blocks[1]);
    const Read read = read_fst(fst_of(damaged));
    EXPECT_EQ(read.edges, some_edges());
    EXPECT_EQ(read.cause(), CaptureCause::damaged);
    EXPECT_THAT(text_of(read), HasSubstr("a.fst: block 2: is damaged"));
  };
  damage([](FstPartsBlock& block) { block.packing = 'Q'; });
  damage([](FstPartsBlock& block) { block.chains = "\x05zzzzz"; });
  damage([](FstPartsBlock& block) { block.chains = std::string("\0\x80", 2); });
  damage([](FstPartsBlock& block) { block.chains = std::string("\0\x7C", 2); });
  damage([](FstPartsBlock& block) { block.index = "\x7B"; });
  damage([](FstPartsBlock& block) { block.times_count = 9; });
  damage([](FstPartsBlock& block) { block.times = "\x80"; });
  damage([](FstPartsBlock& block) { block.times.clear(); });
}

TEST(Fst, ClaimsOfSize_AreNotBelieved) {
  FstParts parts = fst_parts_of(ma_slo, some_edges());
  parts.blocks[0].chains = "\xFF\xFF\xFF\xFF\x0F" + parts.blocks[0].chains;
  EXPECT_EQ(read_fst(fst_of(parts)).cause(), CaptureCause::damaged);
  parts = fst_parts_of(ma_slo, some_edges());
  parts.handles = 1U << 21U;
  EXPECT_EQ(read_fst(fst_of(parts)).cause(), CaptureCause::too_many_lines);
  std::string content;
  put_big_endian(content, std::uint64_t{1} << 40U);
  const std::string hierarchy = fst_section(6, content + "\xF0");
  EXPECT_EQ(read_fst(fst_header(-12) + hierarchy).cause(), CaptureCause::block_too_large);
}

TEST(Fst, Hierarchy_IsCheckedEntryByEntry) {
  FstParts parts = fst_parts_of(ma_slo, some_edges());
  const auto cause_of = [&](const std::string& hierarchy) {
    parts.hierarchy = hierarchy;
    return read_fst(fst_of(parts)).cause();
  };
  EXPECT_EQ(cause_of("\xFF"), CaptureCause::malformed);
  EXPECT_EQ(cause_of("\x80"), CaptureCause::malformed);
  EXPECT_EQ(cause_of(std::string("\x10\0MA", 4)), CaptureCause::damaged);
  EXPECT_EQ(cause_of(fst_variable("MA", 1)), CaptureCause::damaged);
  std::string deep;
  for (int i = 0; i < 257; ++i) deep += std::string("\xFE\0a\0\0", 5);
  EXPECT_EQ(cause_of(deep), CaptureCause::malformed);
  EXPECT_EQ(cause_of(std::string("\xFC\0\0note\0\7\xFD", 10)), std::nullopt);
}

TEST(Fst, HierarchyPackedTwice_IsUnpackedTwice) {
  const FstParts parts = fst_parts_of(ma_slo, some_edges());
  const std::string once = lz4_literals(parts.hierarchy);
  std::string content;
  put_big_endian(content, parts.hierarchy.size());
  put_varint(content, once.size());
  const std::string start = fst_header(-12) + fst_block(parts.blocks[0]);
  // Without the geometry, the hierarchy says how many bits a variable has.
  const Read read = read_fst(start + fst_section(7, content + lz4_literals(once)));
  EXPECT_EQ(text_of(read), "");
  EXPECT_EQ(read.edges, some_edges());
  const std::string cut = lz4_literals(once.substr(1));
  EXPECT_EQ(read_fst(start + fst_section(7, content + cut)).cause(), CaptureCause::damaged);
}

TEST(Fst, Content_IsRecognised) {
  const std::string file = fst_of(fst_parts_of(ma_slo, some_edges()));
  for (const char* path : {"a.fst", "a.vcd", "-"}) {
    EXPECT_EQ(read_all(open_capture(memory_bytes(file, 1), path)).edges, some_edges()) << path;
  }
  EXPECT_EQ(read_all(open_capture(memory_bytes("\1\2\3"), "a.fst")).cause(),
            CaptureCause::malformed);
}

}  // namespace fst_test
}  // namespace biss::capture
