#include "capture/saleae_binary.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "capture/open.hpp"
#include "capture/seconds.hpp"
#include "capture/test_capture.hpp"

namespace biss::capture {
namespace saleae_binary_test {

std::string little(std::uint64_t number, std::size_t bytes) {
  std::string text;
  for (; bytes-- > 0; number >>= 8U) text += static_cast<char>(number & 0xFFU);
  return text;
}

std::string number(double value) { return little(std::bit_cast<std::uint64_t>(value), 8); }

std::string header(std::uint64_t version, std::uint64_t type) {
  return "<SALEAE>" + little(version, 4) + little(type, 4);
}

std::string times_of(const std::vector<double>& times) {
  std::string text = little(times.size(), 8);
  for (const double time : times) text += number(time);
  return text;
}

std::string version_0(std::uint64_t level, double begin, double end,
                      const std::vector<double>& times) {
  return header(0, 0) + little(level, 4) + number(begin) + number(end) + times_of(times);
}

struct Chunk {
  std::uint64_t level = 0;
  double rate = 0;
  double begin = 0;
  double end = 0;
  std::vector<double> times = {};
};

std::string version_1(const std::vector<Chunk>& chunks) {
  std::string text = header(1, 0) + little(chunks.size(), 8);
  for (const Chunk& chunk : chunks) {
    text += little(chunk.level, 4) + number(chunk.rate) + number(chunk.begin) + number(chunk.end) +
            times_of(chunk.times);
  }
  return text;
}

Read read_binary(std::string_view bytes, std::size_t block = one_block) {
  return read_all(open_saleae_binary(memory_bytes(bytes, block), "MA"));
}

// The first of these samples of Saleae's own documents: a 44 byte header, unaligned numbers.
TEST(SaleaeBinary, Version0_AlternatesFromTheFirstLevel) {
  const std::string bytes = version_0(0, -0.5e-6, 2e-6, {-0.1e-6, 0, 1.25e-6});
  EXPECT_EQ(bytes.size(), 44U + 3 * 8U);
  for (const std::size_t block : {std::size_t{1}, std::size_t{7}, one_block}) {
    const Read read = read_binary(bytes, block);
    EXPECT_FALSE(read.error);
    EXPECT_EQ(read.lines, std::vector<std::string>{"MA"});
    EXPECT_EQ(read.edges, (std::vector{edge(-500'000, 0, '0'), edge(-100'000, 0, '1'),
                                       edge(0, 0, '0'), edge(1'250'000, 0, '1')}));
    EXPECT_EQ(read.end_time, microseconds(2));
  }
  EXPECT_EQ(open_saleae_binary(memory_bytes(bytes), "MA").value()->sample_period(), Picoseconds{});
}

TEST(SaleaeBinary, ChannelWithoutChanges_HasItsLevelAndEnd) {
  const Read read = read_binary(version_0(1, 0, 1e-3, {}));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges, std::vector{edge(0, 0, '1')});
  EXPECT_EQ(read.end_time, milliseconds(1));
}

TEST(SaleaeBinary, GapBetweenChunks_IsUnknown) {
  const Read read = read_binary(version_1(
      {{1, 1e8, 0, 1e-6, {0.5e-6}}, {0, 1e8, 5e-6, 6e-6, {5.5e-6}}, {1, 1e8, 8e-6, 9e-6, {}}}));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges,
            (std::vector{edge(0, 0, '1'), edge(500'000, 0, '0'), edge(1'000'000, 0, 'x'),
                         edge(5'000'000, 0, '0'), edge(5'500'000, 0, '1'), edge(6'000'000, 0, 'x'),
                         edge(8'000'000, 0, '1')}));
  EXPECT_EQ(read.end_time, microseconds(9));
}

TEST(SaleaeBinary, ChunkThatBeginsASampleAfterTheLast_HasNoGap) {
  const Read read = read_binary(version_1(
      {{1, 1e8, 0, 1e-6, {0.5e-6}}, {0, 1e8, 1.01e-6, 2e-6, {}}, {1, 1e8, 2e-6, 3e-6, {}}}));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges,
            (std::vector{edge(0, 0, '1'), edge(500'000, 0, '0'), edge(2'000'000, 0, '1')}));
}

TEST(SaleaeBinary, RateOfVersion1_IsTheSamplePeriod) {
  const auto opened = open_saleae_binary(memory_bytes(version_1({{1, 3e6, 0, 1, {}}})), "MA");
  ASSERT_TRUE(opened);
  EXPECT_EQ((*opened)->sample_period(), picoseconds(333'334));
  EXPECT_EQ((*opened)->sample_rate(), megahertz(3));
}

TEST(SaleaeBinary, ManyChangesInSmallBlocks_AreAllRead) {
  std::mt19937_64 random(7'602);
  std::vector<double> times;
  std::vector<wire::Edge> wanted{edge(0, 0, '0')};
  std::int64_t now = 0;
  for (int i = 0; i < 50'000; ++i) {
    now += static_cast<std::int64_t>(random() % 1'000'000);
    times.push_back(seconds_of(Picoseconds{now}));
    wanted.push_back(edge(now, 0, i % 2 == 0 ? '1' : '0'));
  }
  const std::string bytes = version_0(0, 0, 1, times);
  for (const std::size_t block : {std::size_t{13}, one_block}) {
    EXPECT_TRUE(read_binary(bytes, block).edges == wanted);
  }
}

TEST(SaleaeBinary, CutAnywhere_GivesTheChangesBeforeAndTruncated) {
  const std::string bytes =
      version_1({{1, 1e8, 0, 1e-6, {0.1e-6, 0.2e-6}}, {0, 1e8, 2e-6, 3e-6, {}}});
  const Read whole = read_binary(bytes);
  for (std::size_t kept = 8; kept < bytes.size(); ++kept) {
    const Read read = read_binary(std::string_view(bytes).substr(0, kept));
    EXPECT_EQ(read.cause(), CaptureCause::truncated) << kept;
    EXPECT_EQ(read.edges,
              std::vector(whole.edges.begin(),
                          whole.edges.begin() + static_cast<std::ptrdiff_t>(read.edges.size())))
        << kept;
  }
  EXPECT_EQ(read_binary(std::string_view(bytes).substr(0, bytes.size() - 1)).edges.size(), 3U);
}

TEST(SaleaeBinary, WhatTheFormatDoesNotAllow_IsNamed) {
  using Limits = std::numeric_limits<double>;
  const double nan = Limits::quiet_NaN();
  const double infinity = Limits::infinity();
  const auto cause = [](const std::string& bytes) { return read_binary(bytes).cause(); };
  EXPECT_EQ(cause(version_0(2, 0, 1, {})), CaptureCause::malformed);
  EXPECT_EQ(cause(version_0(0, nan, 1, {})), CaptureCause::malformed);
  EXPECT_EQ(cause(version_0(0, 0, infinity, {})), CaptureCause::malformed);
  EXPECT_EQ(cause(version_0(0, 0, 1, {nan})), CaptureCause::malformed);
  EXPECT_EQ(cause(version_0(0, 0, 1e300, {})), CaptureCause::time_out_of_range);
  EXPECT_EQ(cause(version_0(0, 1, 0, {})), CaptureCause::time_backwards);
  EXPECT_EQ(cause(version_0(0, 1, 2, {0.5})), CaptureCause::time_backwards);
  EXPECT_EQ(cause(version_0(0, 0, 2, {1, 0.5})), CaptureCause::time_backwards);
  EXPECT_EQ(cause(version_0(0, 0, 2, {}) + "x"), CaptureCause::malformed);
  EXPECT_EQ(cause(version_1({})), CaptureCause::empty);
  EXPECT_EQ(cause(version_1({{0, nan, 0, 1, {}}})), CaptureCause::malformed);
  EXPECT_EQ(cause(version_1({{0, -1, 0, 1, {}}})), CaptureCause::malformed);
  EXPECT_EQ(cause(version_1({{0, 0, 0, 1, {}}})), std::nullopt);
  EXPECT_EQ(cause(version_1({{0, 1e6, 0, 1, {}}, {0, 1e6, 0.5, 2, {}}})),
            CaptureCause::time_backwards);
  EXPECT_EQ(cause(header(2, 0)), CaptureCause::unknown_format);
  EXPECT_EQ(cause(header(0, 1)), CaptureCause::truncated);
  EXPECT_EQ(cause(header(0, 2)), CaptureCause::malformed);
}

TEST(SaleaeBinary, ErrorInAChunk_NamesIt) {
  const Read read = read_binary(version_1({{0, 1e6, 0, 1, {}}, {0, 1e6, 2, 3, {1.5}}}));
  ASSERT_TRUE(read.error);
  EXPECT_EQ(capture_error_text(*read.error, "a.bin"),
            "a.bin: chunk 2: time runs backwards; sort by time or export the capture again");
}

TEST(SaleaeBinaryWriter, RandomLevels_ComeBack) {
  std::mt19937_64 random(7'603);
  for (int i = 0; i < 200; ++i) {
    std::vector<wire::Edge> edges;
    std::int64_t now = -static_cast<std::int64_t>(random() % 1'000'000);
    char level = '0';
    const std::size_t count = 1 + random() % 300;
    const bool unknown = i % 2 == 0;
    for (std::size_t k = 0; k < count; ++k) {
      edges.push_back(edge(now, 0, level));
      now += static_cast<std::int64_t>(1 + random() % 100'000);
      const char before = level;
      while (level == before) level = (unknown ? "01x" : "01")[random() % (unknown ? 3 : 2)];
    }
    if (edges.back().level == wire::Level::unknown) edges.pop_back();
    const Picoseconds end = edges.back().time + nanoseconds(7);
    std::string bytes;
    StringSink sink(bytes);
    SaleaeBinaryWriter writer({"MA"}, megahertz(0), sink);
    ASSERT_TRUE(writer.write(edges).ok());
    ASSERT_TRUE(writer.finish(end).ok());
    const Read read = read_binary(bytes);
    EXPECT_FALSE(read.error);
    ASSERT_TRUE(read.edges == edges) << i;
    EXPECT_EQ(read.end_time, end);
  }
}

TEST(SaleaeBinaryWriter, TwoLines_AreRefused) {
  std::string bytes;
  StringSink sink(bytes);
  SaleaeBinaryWriter writer({"MA", "SLO"}, {}, sink);
  EXPECT_EQ(writer.write({}).error(), WriteCause::too_many_lines);
}

TEST(Spool, MoreThanMemoryHolds_ComesBackFromTheFile) {
  // The largest are 40 MB in 5000 pieces.
  for (const std::size_t count : {std::size_t{0}, std::size_t{10}, std::size_t{5'000}}) {
    Spool spool;
    std::string wanted;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string piece(8'000, static_cast<char>(i % 251));
      wanted += piece;
      ASSERT_TRUE(spool.append(piece));
    }
    ASSERT_TRUE(spool.rewind());
    std::string block(7'777, ' ');
    std::string text;
    while (const std::size_t got = spool.read(block)) text.append(block, 0, got);
    EXPECT_TRUE(text == wanted) << count;
  }
}

TEST(SaleaeBinary, Line_IsCalledAsTheFile) {
  const std::string bytes = version_0(0, 0, 1, {});
  const auto name_in = [&](const char* path) {
    return read_all(open_capture(memory_bytes(bytes), path)).lines.front();
  };
  EXPECT_EQ(name_in("folder.d/digital_0.bin"), "digital_0");
  EXPECT_EQ(name_in("MA.saleae.bin"), "MA");
  EXPECT_EQ(name_in("slo"), "slo");
  EXPECT_EQ(name_in("-"), "digital");
  // The layout of raw samples does not make samples of it.
  const OpenOptions options{.raw = RawLayout{megahertz(1), 1, {{"D0", 0}}}};
  EXPECT_EQ(read_all(open_capture(memory_bytes(bytes), "a.bin", options)).edges.size(), 1U);
}

}  // namespace saleae_binary_test
}  // namespace biss::capture
