#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "capture/open.hpp"
#include "capture/sr.hpp"
#include "capture/test_folder.hpp"
#include "capture/test_samples.hpp"
#include "tests/common/long_run.hpp"
#include "tests/common/random.hpp"

namespace biss::capture {
namespace sr_test {

using testing::ElementsAre;

// Overwrites a number of the directory's entry for a member, counted from 0.
std::string with_directory_field(std::string archive, std::size_t member, std::size_t offset,
                                 std::uint32_t value) {
  std::size_t at = archive.find("PK\x01\x02");
  for (std::size_t i = 0; i < member; ++i) at = archive.find("PK\x01\x02", at + 4);
  for (unsigned i = 0; i < 4; ++i) archive[at + offset + i] = static_cast<char>(value >> (8 * i));
  return archive;
}

constexpr std::size_t crc_field = 16;
constexpr std::size_t compressed_field = 20;
constexpr std::size_t size_field = 24;
constexpr std::size_t place_field = 42;

const std::string some_samples = "\3\3\2\2\3\1\1\3";

TEST(Sr, Chunks_GiveTheEdgesOfTheirSamples) {
  const RawLayout layout = packed_layout({"MA", "SLO"}, megahertz(1));
  const std::vector<wire::Edge> wanted = plain_edges(layout, some_samples);
  Members one_member = session_of({});
  one_member.emplace_back("logic-1", some_samples);
  for (const Members& members :
       {session_of({some_samples}), session_of({"\3\3\2", "\2\3", "", "\1\1\3"}), one_member}) {
    for (const std::size_t block : {std::size_t{1}, one_block}) {
      const Read read = read_sr(zip_of(members), block);
      EXPECT_FALSE(read.error);
      EXPECT_THAT(read.lines, ElementsAre("MA", "SLO"));
      EXPECT_EQ(read.edges, wanted);
      EXPECT_EQ(read.end_time, microseconds(7));
    }
  }
}

TEST(Sr, MoreThanNineChunks_ComeInTheOrderOfTheirNumbers) {
  std::vector<std::string> chunks;
  std::string all;
  for (int i = 0; i < 23; ++i) {
    chunks.push_back(std::string(static_cast<std::size_t>(i + 1), static_cast<char>(i % 4)));
    all += chunks.back();
  }
  Members members = session_of(chunks);
  std::reverse(members.begin(), members.end());
  EXPECT_EQ(read_sr(zip_of(members)).edges,
            plain_edges(packed_layout({"MA", "SLO"}, megahertz(1)), all));
}

TEST(Sr, ChunksThatCutSamples_GiveTheSameEdges) {
  std::mt19937_64 random = test::random_of(7'404);
  for (std::size_t unit = 1; unit <= max_unit_bytes; ++unit) {
    const RawLayout layout = random_layout(random, unit, megahertz(48));
    const std::string bytes = random_samples(random, unit, 20'000);
    Members members{{"version", "1"}, {"metadata", sr_metadata_text(layout)}};
    for (std::size_t at = 0, k = 1; at < bytes.size(); ++k) {
      const std::size_t size = 1 + random() % 9'000;
      members.emplace_back("logic-1-" + std::to_string(k), bytes.substr(at, size));
      at += size;
    }
    const Read read = read_sr(zip_of(members));
    EXPECT_FALSE(read.error);
    // Probes come in the order of their numbers.
    RawLayout sorted = layout;
    std::sort(sorted.lines.begin(), sorted.lines.end(),
              [](const SampleLine& a, const SampleLine& b) { return a.bit < b.bit; });
    EXPECT_EQ(read.edges, plain_edges(sorted, bytes)) << unit;
  }
}

TEST(Sr, MemberLargerThanIsInflatedAtOnce_IsReadInPieces) {
  if (!test::long_run()) GTEST_SKIP() << "make test-long runs it";
  std::string bytes(40U * 1024U * 1024U, '\3');
  bytes[35U * 1024U * 1024U] = '\2';
  Members members = session_of({});
  members.emplace_back("logic-1", bytes);
  const std::string archive = zip_of(members);
  const Read read = read_sr(archive);
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges, plain_edges(packed_layout({"MA", "SLO"}, megahertz(1)), bytes));
  EXPECT_EQ(read_sr(with_directory_field(archive, 2, crc_field, 1)).cause(), CaptureCause::damaged);
  for (const int wrong : {-1, 1}) {
    const auto size = static_cast<std::uint32_t>(static_cast<int>(bytes.size()) + wrong);
    EXPECT_EQ(read_sr(with_directory_field(archive, 2, size_field, size)).cause(),
              CaptureCause::damaged);
  }
}

TEST(Sr, ArchiveCutAnywhere_ReportsDamaged) {
  const std::string whole = zip_of(session_of({some_samples}));
  for (std::size_t size = 4; size < whole.size(); ++size) {
    ASSERT_EQ(read_sr(whole.substr(0, size)).cause(), CaptureCause::damaged) << size;
  }
}

// A member whose name is damaged is not found, and its samples are missing. A missing last chunk
// cannot be detected.
TEST(Sr, AnyByteDamaged_EndsInACauseOrInNoOtherEdges) {
  const std::string whole = zip_of(session_of({some_samples, some_samples}));
  const std::vector<wire::Edge> edges = read_sr(whole).edges;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (const int flip : {1, 0x80, 0xFF}) {
      std::string damaged = whole;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      const Read read = read_sr(damaged);
      if (read.error) continue;
      ASSERT_LE(read.edges.size(), edges.size());
      EXPECT_TRUE(std::equal(read.edges.begin(), read.edges.end(), edges.begin())) << at;
    }
  }
}

TEST(Sr, LyingDirectory_ReportsDamagedWithTheChunk) {
  const std::string whole = zip_of(session_of({some_samples, std::string(5'000, '\2')}));
  for (const auto& [field, value] :
       {std::pair{size_field, 4'999U}, std::pair{size_field, 5'001U},
        std::pair{size_field, 0xFFFFFFF0U}, std::pair{size_field, 20'000'000U},
        std::pair{crc_field, 0U}, std::pair{compressed_field, 3U}}) {
    const Read read = read_sr(with_directory_field(whole, 3, field, value));
    ASSERT_EQ(read.cause(), CaptureCause::damaged) << field << ' ' << value;
    EXPECT_EQ(read.edges, read_sr(zip_of(session_of({some_samples}))).edges);
    EXPECT_STREQ(read.error->part, "chunk");
    EXPECT_EQ(read.error->part_number, 2U);
    EXPECT_EQ(capture_error_text(*read.error, "a.sr").find("a.sr: chunk 2: is damaged"), 0U);
  }
}

TEST(Sr, MembersInOnePlace_AreABombAndReportDamaged) {
  // A hundred chunks that all claim the compressed bytes of the first.
  std::string bomb =
      zip_of(session_of(std::vector<std::string>(100, std::string(1U << 20U, '\1'))));
  const std::string small = zip_of(session_of({std::string(1U << 20U, '\1')}));
  const std::size_t first = bomb.find("logic-1-1") - 30;
  for (std::size_t i = 0; i < 100; ++i) {
    bomb = with_directory_field(bomb, 2 + i, place_field, static_cast<std::uint32_t>(first));
  }
  const std::size_t directory = bomb.find("PK\x01\x02");
  bomb.erase(first + 1'200, directory - first - 1'200);
  const std::size_t end = bomb.rfind("PK\x05\x06");
  const auto place = static_cast<std::uint32_t>(bomb.find("PK\x01\x02"));
  for (unsigned i = 0; i < 4; ++i) bomb[end + 16 + i] = static_cast<char>(place >> (8 * i));
  const Read read = read_sr(bomb);
  EXPECT_EQ(read.cause(), CaptureCause::damaged);
  EXPECT_TRUE(read.edges.empty());
  EXPECT_FALSE(read_sr(small).error);
}

TEST(Sr, ChunkMissingBetweenOthers_ReportsItBehindTheEdges) {
  Members members = session_of({some_samples, "\1", "\2"});
  members.erase(members.begin() + 3);
  const Read read = read_sr(zip_of(members));
  ASSERT_EQ(read.cause(), CaptureCause::damaged);
  EXPECT_EQ(read.error->part_number, 2U);
  EXPECT_EQ(read.end_time, microseconds(7));
}

TEST(Sr, MembersThatAreMissing_AreNamed) {
  EXPECT_EQ(read_sr(zip_of(session_of({}))).cause(), CaptureCause::empty);
  EXPECT_EQ(read_sr(zip_of(session_of({""}))).cause(), CaptureCause::empty);
  EXPECT_EQ(read_sr(zip_of({{"other", "x"}})).cause(), CaptureCause::unknown_format);
  EXPECT_EQ(read_sr(zip_of({})).cause(), CaptureCause::unknown_format);
  EXPECT_EQ(read_sr(zip_of({{"version", "2"}})).cause(), CaptureCause::unknown_format);
  EXPECT_EQ(read_sr(zip_of({{"version", "3"}, {"metadata", ""}})).cause(), CaptureCause::malformed);
  EXPECT_EQ(read_sr(zip_of({{"version", "2"}, {"metadata", ""}})).cause(), CaptureCause::malformed);
  const std::string long_text(2U << 20U, '\n');
  EXPECT_EQ(read_sr(zip_of({{"version", "2"}, {"metadata", long_text}})).cause(),
            CaptureCause::damaged);
}

TEST(Sr, MembersThatAreNoChunk_AreRefusedByName) {
  using testing::HasSubstr;
  const auto refusal = [](const std::string& name, const Members& members) {
    const Read read = read_sr(zip_of(members));
    EXPECT_TRUE(read.error) << name;
    EXPECT_TRUE(read.edges.empty()) << name;
    return read.error ? capture_error_text(*read.error, "a.sr") : "";
  };
  for (const std::string name :
       {"logic-1-0", "logic-1-02", "logic-1-+2", "logic-1- 2", "logic-1-", "logic-1-2a",
        "logic-1-2.0", "logic-1-x", "logic-1.bak", "logic-1/1", "logic-10",
        "logic-1-18446744073709551618", "logic-1-2-1", "./logic-1-2", "Logic-1-2", "a/logic-1-2"}) {
    Members members = session_of({some_samples, some_samples});
    members.emplace_back(name, some_samples);
    EXPECT_THAT(refusal(name, members), HasSubstr("'" + name.substr(0, 30))) << name;
    members.erase(members.begin() + 3);
    EXPECT_THAT(refusal(name, members), HasSubstr("'" + name.substr(0, 30))) << name;
  }
  Members both = session_of({some_samples});
  both.emplace_back("logic-1", some_samples);
  EXPECT_THAT(refusal("logic-1", both), HasSubstr("'logic-1'"));
  Members hostile = session_of({some_samples});
  hostile.emplace_back("logic-1-\xE2\x80\xAE", some_samples);
  EXPECT_THAT(refusal("direction", hostile), HasSubstr("'logic-1-\?\?\?'"));
  for (const std::string twice : {"logic-1-1", "metadata", "version"}) {
    Members members = session_of({some_samples});
    members.emplace_back(twice, twice == "metadata" ? members[1].second : "\1\2");
    EXPECT_THAT(refusal(twice, members), HasSubstr("'" + twice + "'")) << twice;
  }
  Members other = session_of({some_samples});
  other.emplace_back("analog-1-3-1", "abcd");
  EXPECT_FALSE(read_sr(zip_of(other)).error);
}

TEST(Sr, LastSampleNotWhole_ReportsTruncated) {
  Members members = session_of({std::string("\1\0\3", 3)});
  members[1].second.replace(members[1].second.find("unitsize=1"), 10, "unitsize=2");
  const Read read = read_sr(zip_of(members));
  EXPECT_EQ(read.cause(), CaptureCause::truncated);
  EXPECT_EQ(read.edges.size(), 2U);
}

TEST(Sr, FileOfItsOwn_IsReadWhereItLies) {
  const test::Folder folder;
  const std::string archive = zip_of(session_of({some_samples}));
  EXPECT_EQ(read_all(open_capture(folder.file("line.sr", archive))).edges, read_sr(archive).edges);
}

TEST(Sr, PipeOfMoreThanFitsInMemory_IsReadThroughAFile) {
  if (!test::long_run()) GTEST_SKIP() << "make test-long runs it";
  std::mt19937_64 random = test::random_of(7'405);
  std::string noise;
  noise.reserve(8'400'000);
  // Two lines that change now and then, among six that always do.
  for (std::size_t i = 0; i < 1'050'000; ++i) {
    const std::uint64_t others = random() & ~std::uint64_t{0x0303'0303'0303'0303};
    const std::uint64_t sample = others | i / 10 % 4 * 0x0101'0101'0101'0101;
    for (unsigned k = 0; k < 64; k += 8) noise += static_cast<char>(sample >> k);
  }
  const RawLayout layout = packed_layout({"MA", "SLO"}, megahertz(1));
  const std::string archive = zip_of(session_of({noise, noise, noise}));
  ASSERT_GT(archive.size(), 17U << 20U);
  const Read read = read_sr(archive, 1U << 20U);
  EXPECT_FALSE(read.error);
  EXPECT_EQ(read.edges, plain_edges(layout, noise + noise + noise));
}

TEST(SrWriter, RandomEdges_ComeBackAtTheirSamples) {
  std::mt19937_64 random = test::random_of(7'406);
  for (const std::size_t lines : {1U, 2U, 8U, 9U, 33U, 64U}) {
    RawLayout layout = packed_layout(std::vector<std::string>(lines), megahertz(48));
    std::vector<std::string> names;
    for (std::size_t i = 0; i < lines; ++i) names.push_back("n " + std::to_string(i));
    const std::string bytes = random_samples(random, layout.unit_bytes, 50'000);
    const std::vector<wire::Edge> edges = plain_edges(layout, bytes);
    std::string archive;
    StringSink sink(archive);
    SrWriter writer(names, layout.rate, sink);
    ASSERT_TRUE(writer.write(edges).ok());
    ASSERT_TRUE(writer.finish(SampleClock(layout.rate).time_of(49'999)).ok());
    const Read read = read_sr(archive);
    EXPECT_FALSE(read.error);
    EXPECT_EQ(read.lines, names);
    EXPECT_EQ(read.edges, edges) << lines;
    EXPECT_EQ(read.end_time, SampleClock(layout.rate).time_of(49'999));
  }
}

TEST(SrWriter, LongRest_TakesSeveralChunksAndLittleRoom) {
  std::string archive;
  StringSink sink(archive);
  SrWriter writer({"MA"}, megahertz(100), sink);
  const std::vector<wire::Edge> edges{edge(0, 0, '1'), edge(99'999'990'000, 0, '0')};
  ASSERT_TRUE(writer.write(edges).ok());
  ASSERT_TRUE(writer.finish(milliseconds(100)).ok());
  EXPECT_LT(archive.size(), 50'000U);
  EXPECT_NE(archive.find("logic-1-3"), std::string::npos);
  EXPECT_EQ(read_sr(archive).edges, edges);
}

TEST(SrWriter, TooManyLines_AreRefused) {
  std::string archive;
  StringSink sink(archive);
  SrWriter writer(std::vector<std::string>(65, "x"), megahertz(1), sink);
  EXPECT_EQ(writer.finish({}).error(), WriteCause::too_many_lines);
}

TEST(ZipWriter, MoreMembersThanAnArchiveHolds_AreRefused) {
  ZipWriter archive;
  std::string out;
  for (int i = 0; i < 65'535; ++i) ASSERT_TRUE(archive.add("m", "", out));
  const std::size_t size = out.size();
  EXPECT_FALSE(archive.add("m", "", out));
  EXPECT_EQ(out.size(), size);
}

}  // namespace sr_test
}  // namespace biss::capture
