#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <string>

#include "capture/samples.hpp"
#include "capture/test_samples.hpp"
#include "tests/common/random.hpp"

namespace biss::capture {
namespace raw_test {

using testing::ElementsAre;

const RawLayout ma_and_slo{megahertz(1), 1, {{"MA", 0}, {"SLO", 1}}};

template <class Writer>
std::string written(const RawLayout& layout, std::span<const wire::Edge> edges, Picoseconds end) {
  std::string bytes;
  StringSink sink(bytes);
  Writer writer(layout, sink);
  EXPECT_TRUE(writer.write(edges).ok());
  EXPECT_TRUE(writer.finish(end).ok());
  return bytes;
}

TEST(Raw, Samples_BecomeEdgesAtTheirTimes) {
  const Read read = read_raw("\x03\x03\x02\x42\x01", ma_and_slo);
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.lines, ElementsAre("MA", "SLO"));
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(0, 1, '1'), edge(2'000'000, 0, '0'),
                                      edge(4'000'000, 0, '1'), edge(4'000'000, 1, '0')));
  EXPECT_EQ(read.end_time, microseconds(4));
}

TEST(Raw, SamplePeriod_IsTheLongestBetweenTwoSamples) {
  for (const auto& [rate, period] : {std::pair{megahertz(1), picoseconds(1'000'000)},
                                     std::pair{megahertz(48), picoseconds(20'834)}}) {
    const auto opened = open_raw(memory_bytes("\x03"), {rate, 1, ma_and_slo.lines});
    EXPECT_EQ((*opened)->sample_period(), period);
  }
}

TEST(Raw, RandomSamplesOfEveryUnitSize_AgreeWithThePlainReading) {
  std::mt19937_64 random = test::random_of(7'402);
  for (std::size_t unit = 1; unit <= max_unit_bytes; ++unit) {
    for (int i = 0; i < 60; ++i) {
      SCOPED_TRACE(testing::Message() << "unit " << unit << " run " << i);
      const RawLayout layout =
          random_layout(random, unit, Hertz{1U + static_cast<std::uint32_t>(random())});
      const std::string bytes = random_samples(random, unit, 1 + random() % 3'000);
      const Read read = read_raw(bytes, layout, 1 + random() % (i % 2 == 0 ? 20 : 10'000));
      ASSERT_FALSE(read.error);
      ASSERT_EQ(read.edges, plain_edges(layout, bytes));
      ASSERT_EQ(read.end_time, SampleClock(layout.rate).time_of(bytes.size() / unit - 1));
    }
  }
}

TEST(Raw, SixtyFourLinesThatAllChange_FillNoBlockTooFar) {
  std::string bytes;
  for (int i = 0; i < 3'000; ++i) bytes += std::string(8, i % 2 == 0 ? '\0' : '\xFF');
  RawLayout layout{megahertz(10), 8, {}};
  for (unsigned bit = 0; bit < 64; ++bit) layout.lines.push_back({"l" + std::to_string(bit), bit});
  EXPECT_EQ(read_raw(bytes, layout).edges, plain_edges(layout, bytes));
}

TEST(Raw, LastSampleNotWhole_ReportsTruncatedBehindTheEdges) {
  const RawLayout layout{megahertz(1), 3, {{"MA", 17}}};
  const Read read = read_raw(std::string("\0\0\2\0\0\0\1\2", 8), layout, 2);
  EXPECT_EQ(read.cause(), CaptureCause::truncated);
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '1'), edge(1'000'000, 0, '0')));
  EXPECT_EQ(read_raw("\1\2", layout).cause(), CaptureCause::truncated);
}

TEST(Raw, NoByte_ReportsEmpty) { EXPECT_EQ(read_raw("", ma_and_slo).cause(), CaptureCause::empty); }

TEST(Raw, LayoutsThatCannotBe_ReportBadLayout) {
  const SampleLine ma{"MA", 0};
  for (const RawLayout& layout :
       {RawLayout{{}, 1, {ma}}, RawLayout{hertz(1), 0, {ma}}, RawLayout{hertz(1), 9, {ma}},
        RawLayout{hertz(1), 1, {}}, RawLayout{hertz(1), 1, {{"MA", 8}}},
        RawLayout{hertz(1), 1, {ma, {"SLO", 0}}}}) {
    const Read read = read_raw("\1", layout);
    ASSERT_EQ(read.cause(), CaptureCause::bad_layout);
    EXPECT_NE(read.error->expected, nullptr);
  }
}

// The same samples repeatedly, far more than a file would hold.
class EndlessPieces final : public SamplePieces {
 public:
  Result<bool, CaptureError> fetch(PackedSamples& piece, const FetchWish&) override {
    piece.bytes = bytes_;
    return true;
  }

 private:
  std::vector<std::uint8_t> bytes_ = std::vector<std::uint8_t>(1'000'000, 1);
};

TEST(Raw, SamplesBeyondTheRange_ReportTimeOutOfRange) {
  const RawLayout layout{hertz(1), 1, {{"MA", 0}}};
  const Read read = read_all(open_samples(layout, std::make_unique<EndlessPieces>()));
  EXPECT_EQ(read.cause(), CaptureCause::time_out_of_range);
  EXPECT_EQ(read.edges.size(), 1U);
  EXPECT_EQ(read.end_time.count, 9'223'372 * picoseconds_per_second);
}

TEST(RawWriter, Edges_ShowInTheFirstSampleAtOrBehindThem) {
  const std::vector<wire::Edge> edges{edge(0, 0, '1'),         edge(0, 1, '1'),
                                      edge(1'000'000, 0, '0'), edge(2'000'001, 1, '0'),
                                      edge(4'100'000, 0, '1'), edge(4'900'000, 0, '0'),
                                      edge(5'500'000, 1, 'x')};
  EXPECT_EQ(written<RawWriter>(ma_and_slo, edges, picoseconds(7'000'001)),
            std::string("\3\2\2\0\0\0\0\0\0", 9));
  EXPECT_EQ(written<RawWriter>(ma_and_slo, edges, {}).size(), 7U);
}

TEST(RawWriter, NoEdge_IsOneSampleOfLowLines) {
  EXPECT_EQ(written<RawWriter>(ma_and_slo, {}, {}), std::string(1, '\0'));
}

TEST(RawWriter, RandomSamples_ComeBackByteForByte) {
  std::mt19937_64 random = test::random_of(7'403);
  for (std::size_t unit = 1; unit <= max_unit_bytes; ++unit) {
    for (int i = 0; i < 20; ++i) {
      RawLayout layout =
          random_layout(random, unit, Hertz{1U + static_cast<std::uint32_t>(random())});
      layout.lines.clear();
      for (unsigned bit = 0; bit < 8 * unit; ++bit)
        layout.lines.push_back({std::to_string(bit), bit});
      const std::string bytes = random_samples(random, unit, 1 + random() % 30'000);
      const Read read = read_raw(bytes, layout);
      ASSERT_EQ(written<RawWriter>(layout, read.edges, read.end_time), bytes) << unit << ' ' << i;
    }
  }
}

TEST(RawWriter, TimeBeforeZeroAndTooManyLines_AreRefused) {
  std::string bytes;
  StringSink sink(bytes);
  RawWriter writer(ma_and_slo, sink);
  const std::array<wire::Edge, 1> early{edge(-1, 0, '1')};
  EXPECT_EQ(writer.write(early).error(), WriteCause::time_before_zero);
  RawWriter other(packed_layout(std::vector<std::string>(65, "x"), hertz(1)), sink);
  EXPECT_EQ(other.finish({}).error(), WriteCause::too_many_lines);
}

TEST(RawWriter, FullDisk_StopsALongRest) {
  FailingSink sink(false);
  RawWriter writer({hertz(UINT32_MAX), 1, {{"MA", 0}}}, sink);
  // A hundred days of samples: only an early end lets this return.
  EXPECT_EQ(writer.finish(milliseconds(8'640'000'000)).error(), WriteCause::write_failed);
}

}  // namespace raw_test
}  // namespace biss::capture
