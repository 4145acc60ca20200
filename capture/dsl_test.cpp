#include "capture/dsl.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "capture/open.hpp"
#include "capture/test_samples.hpp"

namespace biss::capture {
namespace dsl_test {

Read read_dsl(std::string_view bytes) { return read_all(open_zip(memory_bytes(bytes))); }

std::string header_of(std::uint64_t samples, std::uint64_t blocks,
                      const std::vector<SampleLine>& lines, const std::string& version = "3") {
  std::string text = "[version]\nversion = " + version +
                     "\n[header]\ndriver = DSLogic\ndevice mode = 0\ncapturefile = data\n"
                     "total samples = " +
                     std::to_string(samples) + "\ntotal probes = " + std::to_string(lines.size()) +
                     "\ntotal blocks = " + std::to_string(blocks) +
                     "\nsamplerate = 100 MHz\ntrigger time = 1700000000000\ntrigger pos = 0\n";
  for (const SampleLine& line : lines) {
    text += "probe" + std::to_string(line.bit) + " = " + line.name + '\n';
  }
  return text;
}

// Bits of one line of these samples, the first in the lowest bit.
std::string plane_of(std::string_view samples, unsigned bit) {
  std::string plane((samples.size() + 7) / 8, '\0');
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if ((static_cast<unsigned char>(samples[i]) >> bit & 1) != 0) {
      plane[i / 8] = static_cast<char>(plane[i / 8] | 1 << i % 8);
    }
  }
  return plane;
}

const std::vector<SampleLine> ma_and_slo{{"MA", 2}, {"SLO", 5}};

Members capture_of(std::string_view samples, const std::vector<SampleLine>& lines) {
  Members members{{"header", header_of(samples.size(), 1, lines)}};
  for (const SampleLine& line : lines) {
    members.emplace_back("L-" + std::to_string(line.bit) + "/0", plane_of(samples, line.bit));
  }
  return members;
}

std::string some_samples(std::size_t count) {
  std::mt19937_64 random(7'701);
  return random_samples(random, 1, count);
}

void expect_same(const Read& read, const std::vector<SampleLine>& lines, std::string_view samples) {
  const RawLayout layout{megahertz(100), 1, lines};
  EXPECT_FALSE(read.error);
  EXPECT_TRUE(read.edges == plain_edges(layout, samples));
  EXPECT_EQ(read.end_time, nanoseconds(10) * static_cast<std::int64_t>(samples.size() - 1));
}

TEST(Dsl, SamplesOfAnyNumber_GiveTheEdgesOfAPlainReader) {
  for (const std::size_t count : {1U, 7U, 8U, 63U, 64U, 65U, 1'000U, 100'000U}) {
    const std::string samples = some_samples(count);
    const Read read = read_dsl(zip_of(capture_of(samples, ma_and_slo)));
    SCOPED_TRACE(count);
    EXPECT_EQ(read.lines, (std::vector<std::string>{"MA", "SLO"}));
    expect_same(read, ma_and_slo, samples);
  }
}

TEST(Dsl, EightProbes_GiveTheEdgesOfAPlainReader) {
  std::vector<SampleLine> lines;
  for (unsigned bit = 0; bit < 8; ++bit) lines.push_back({"D" + std::to_string(bit), bit});
  const std::string samples = some_samples(50'000);
  expect_same(read_dsl(zip_of(capture_of(samples, lines))), lines, samples);
}

TEST(Dsl, SeveralBlocks_AreOneCapture) {
  constexpr std::size_t block_bytes = dsl_block_samples / 8;
  std::string ma(block_bytes, '\xFF');
  std::string slo(block_bytes, '\0');
  slo[block_bytes - 1] = '\x80';  // the last sample of the block
  const Members members{{"header", header_of(dsl_block_samples + 80, 2, ma_and_slo)},
                        {"L-2/0", ma},
                        {"L-5/0", slo},
                        {"L-2/1", std::string(10, '\0')},
                        {"L-5/1", std::string("\1") + std::string(9, '\0')}};
  const Read read = read_dsl(zip_of(members));
  EXPECT_FALSE(read.error);
  const std::int64_t second = std::int64_t{dsl_block_samples} * 10'000;
  EXPECT_EQ(read.edges,
            (std::vector{edge(0, 0, '1'), edge(0, 1, '0'), edge(second - 10'000, 1, '1'),
                         edge(second, 0, '0'), edge(second + 10'000, 1, '0')}));
  EXPECT_EQ(read.end_time.count, second + 790'000);
  Members cut = members;
  cut.erase(cut.begin() + 3);
  const Read missing = read_dsl(zip_of(cut));
  EXPECT_EQ(missing.cause(), CaptureCause::damaged);
  EXPECT_EQ(missing.edges.size(), 3U);
  EXPECT_EQ(
      capture_error_text(*missing.error, "a.dsl"),
      "a.dsl: block 2: is damaged, expected this block of every probe; copy or save the capture "
      "again");
  Members shorter = members;
  shorter[1].second.resize(block_bytes - 1);
  shorter[2].second.resize(block_bytes - 1);
  EXPECT_EQ(read_dsl(zip_of(shorter)).cause(), CaptureCause::damaged);
}

TEST(Dsl, SamplesThatWholeBytesDoNotHold_AreNoFault) {
  const std::string samples = some_samples(1'000);
  Members members = capture_of(std::string_view(samples).substr(0, 960), ma_and_slo);
  members[0].second = header_of(1'000, 1, ma_and_slo);
  expect_same(read_dsl(zip_of(members)), ma_and_slo, std::string_view(samples).substr(0, 960));
  members[0].second = header_of(1'100, 1, ma_and_slo);
  const Read read = read_dsl(zip_of(members));
  EXPECT_EQ(read.cause(), CaptureCause::truncated);
  EXPECT_EQ(read.end_time, nanoseconds(9'590));
}

TEST(Dsl, Version1_HasSamplesOfTwoBytes) {
  const std::string samples = some_samples(2'000);
  for (const char* version : {"[version]\nversion = 1\n", ""}) {
    const Members members{
        {"header", std::string(version) +
                       "[header]\ncapturefile = data\ntotal samples = 1000\ntotal probes = 16\n"
                       "samplerate = 100 MHz\nprobe3 = MA\nprobe15 = SLO\n"},
        {"data", samples}};
    const Read read = read_dsl(zip_of(members));
    EXPECT_FALSE(read.error);
    const RawLayout layout{megahertz(100), 2, {{"MA", 3}, {"SLO", 15}}};
    EXPECT_TRUE(read.edges == plain_edges(layout, samples));
  }
}

TEST(Dsl, Header_IsCheckedRowByRow) {
  const auto cause_of = [](const std::string& text) -> std::optional<CaptureCause> {
    const auto parsed = parse_dsl_header(text);
    return parsed ? std::nullopt : std::optional(parsed.error().cause);
  };
  const std::string good = header_of(8, 1, ma_and_slo);
  EXPECT_EQ(cause_of(good), std::nullopt);
  EXPECT_EQ(cause_of("[other]\nprobe99 = x\n" + good), std::nullopt);
  EXPECT_EQ(cause_of(header_of(8, 1, ma_and_slo, "2")), std::nullopt);
  for (const char* version : {"0", "4", "x"}) {
    EXPECT_EQ(cause_of(header_of(8, 1, ma_and_slo, version)), CaptureCause::malformed) << version;
  }
  for (const char* row : {"samplerate = 0\n", "samplerate = fast\n", "total samples = -1\n",
                          "total blocks = many\n", "probe64 = x\n", "probe = x\n", "nonsense\n"}) {
    EXPECT_EQ(cause_of(good + row), CaptureCause::malformed) << row;
  }
  EXPECT_EQ(cause_of(good + "device mode = 1\n"), CaptureCause::unknown_format);
  EXPECT_EQ(cause_of("[header]\nsamplerate = 1 MHz\n"), CaptureCause::malformed);
  EXPECT_EQ(cause_of(""), CaptureCause::malformed);
  EXPECT_EQ(cause_of("[header]\nsamplerate = 1 MHz\ncapturefile = data\nprobe16 = x\n"),
            CaptureCause::malformed);
}

TEST(Dsl, WhatTheHeaderDoesNotCount_IsRefusedByName) {
  const std::string samples = some_samples(1'000);
  const Members good = capture_of(samples, ma_and_slo);
  for (const std::string name :
       {"L-2/1", "L-2/00", "L-02/0", "L-3/0", "L-2/0x", "L-2", "L-/0", "header", "L-2/0"}) {
    Members members = good;
    members.emplace_back(name, good[1].second);
    const Read read = read_dsl(zip_of(members));
    ASSERT_TRUE(read.error) << name;
    EXPECT_NE(capture_error_text(*read.error, "a.dsl").find("'" + name + "'"), std::string::npos)
        << capture_error_text(*read.error, "a.dsl");
  }
  Members members = good;
  members[0].second = header_of(samples.size(), 2, ma_and_slo);
  const Read more = read_dsl(zip_of(members));
  ASSERT_TRUE(more.error);
  EXPECT_NE(std::string(more.error->expected).find("total blocks"), std::string::npos);
  const std::string header = header_of(8, 1, ma_and_slo);
  for (const char* row : {"samplerate = 1 MHz\n", "total samples = 8\n", "total blocks = 1\n",
                          "probe2 = MA\n", "probe02 = MB\n", "capturefile = data\n"}) {
    const auto parsed = parse_dsl_header(header + row);
    ASSERT_FALSE(parsed) << row;
    EXPECT_NE(std::string(parsed.error().expected).find("once"), std::string::npos) << row;
  }
  // Version 1 has its samples in one member.
  const std::string version_1 =
      "[header]\ncapturefile = data\nsamplerate = 100 MHz\nprobe3 = MA\nprobe15 = SLO\n";
  EXPECT_TRUE(
      read_dsl(zip_of({{"header", version_1}, {"data", samples}, {"data-01", samples}})).error);
}

// Whole words of 64 samples are stored.
TEST(Dsl, MoreSamplesThanTheHeaderHas_AreRefused) {
  Members members = capture_of(some_samples(1'000), ma_and_slo);
  for (const std::uint64_t said : {1U, 500U, 936U, 937U, 999U}) {
    members[0].second = header_of(said, 1, ma_and_slo);
    const Read read = read_dsl(zip_of(members));
    if (said > 936) {
      EXPECT_FALSE(read.error) << said;
    } else {
      ASSERT_EQ(read.cause(), CaptureCause::damaged) << said;
      EXPECT_STREQ(read.error->expected, "no more samples than the header gives");
    }
  }
}

TEST(Dsl, DamagedArchives_AreNamed) {
  const std::string samples = some_samples(1'000);
  Members members = capture_of(samples, ma_and_slo);
  members[2].second.resize(100);
  EXPECT_EQ(read_dsl(zip_of(members)).cause(), CaptureCause::damaged);
  EXPECT_EQ(read_dsl(zip_of({{"header", header_of(0, 0, ma_and_slo)}})).cause(),
            CaptureCause::empty);
  EXPECT_EQ(read_dsl(zip_of({{"header", header_of(~0ULL, 0, ma_and_slo)}})).cause(),
            CaptureCause::damaged);
  EXPECT_EQ(read_dsl(zip_of({{"other", "x"}})).cause(), CaptureCause::unknown_format);
  EXPECT_EQ(read_dsl("no archive").cause(), CaptureCause::damaged);
  std::string flipped = zip_of(capture_of(samples, ma_and_slo));
  flipped[flipped.find("L-2/0") + 10] ^= 4;
  EXPECT_EQ(read_dsl(flipped).cause(), CaptureCause::damaged);
}

std::string written(const RawLayout& layout, const std::vector<wire::Edge>& edges,
                    Picoseconds end) {
  std::string bytes;
  StringSink sink(bytes);
  std::vector<std::string> names;
  for (const SampleLine& line : layout.lines) names.push_back(line.name);
  DslWriter writer(names, layout.rate, sink);
  EXPECT_TRUE(writer.write(edges).ok());
  EXPECT_TRUE(writer.finish(end).ok());
  return bytes;
}

TEST(DslWriter, RandomSamples_ComeBack) {
  std::mt19937_64 random(7'702);
  for (int i = 0; i < 40; ++i) {
    const std::size_t unit_bytes = 1 + random() % 8;
    RawLayout layout = random_layout(random, unit_bytes, megahertz(100));
    const std::string samples = random_samples(random, unit_bytes, 1 + random() % 3'000);
    const auto edges = plain_edges(layout, samples);
    const Picoseconds end =
        nanoseconds(10) * static_cast<std::int64_t>(samples.size() / unit_bytes - 1);
    const Read read = read_dsl(written(layout, edges, end));
    EXPECT_FALSE(read.error);
    EXPECT_EQ(read.lines.size(), layout.lines.size());
    EXPECT_EQ(read.end_time, end);
    // Changes with the same time come by lines here and by bits there.
    std::vector<wire::Edge> sorted = edges;
    std::stable_sort(sorted.begin(), sorted.end(), [](const wire::Edge& a, const wire::Edge& b) {
      return a.time != b.time ? a.time < b.time : a.line < b.line;
    });
    ASSERT_TRUE(read.edges == sorted) << i;
  }
}

TEST(DslWriter, ChangesAroundTheEndOfABlock_ComeBack) {
  const std::int64_t block = std::int64_t{dsl_block_samples} * 10'000;
  const std::vector<wire::Edge> edges{edge(0, 0, '1'),
                                      edge(0, 1, '0'),
                                      edge(block - 20'000, 1, '1'),
                                      edge(block - 10'000, 0, '0'),
                                      edge(block, 1, '0'),
                                      edge(block + 10'000, 0, '1'),
                                      edge(2 * block + 30'000, 0, '0')};
  const RawLayout layout{megahertz(100), 1, {{"MA", 0}, {" =SLO", 1}}};
  const Picoseconds end{2 * block + 50'000};
  const Read read = read_dsl(written(layout, edges, end));
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges, edges);
  EXPECT_EQ(read.lines, (std::vector<std::string>{"MA", " =SLO"}));
  EXPECT_EQ(read.end_time, end);
}

TEST(Dsl, Content_DecidesWhateverTheExtension) {
  const std::string samples = some_samples(100);
  const std::string bytes = zip_of(capture_of(samples, ma_and_slo));
  for (const char* path : {"a.dsl", "a.sr", "a.zip", "-"}) {
    EXPECT_FALSE(read_all(open_capture(memory_bytes(bytes), path)).error) << path;
  }
}

}  // namespace dsl_test
}  // namespace biss::capture
