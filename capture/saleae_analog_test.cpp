#include "capture/saleae_binary.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <string>

#include "capture/open.hpp"
#include "capture/test_capture.hpp"
#include "capture/test_compressed.hpp"
#include "capture/test_scope.hpp"

namespace biss::capture {
namespace saleae_analog_test {

using testing::ElementsAre;

const OpenOptions at_one_volt{
    .raw = std::nullopt,
    .analog = {.threshold = Threshold{millivolts(1'000), {}}, .differentials = {}}};

std::string bytes_of(std::uint64_t value, int count = 8) {
  std::string bytes;
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i));
  return bytes;
}

std::string bytes_of_double(double value) { return bytes_of(std::bit_cast<std::uint64_t>(value)); }

std::string samples_of(std::initializer_list<float> volts) {
  std::string bytes;
  for (const float value : volts) bytes += bytes_of(std::bit_cast<std::uint32_t>(value), 4);
  return bytes;
}

std::string signature(std::uint32_t version, std::uint32_t type = 1) {
  return "<SALEAE>" + bytes_of(version, 4) + bytes_of(type, 4);
}

std::string version_0(std::initializer_list<float> volts) {
  return signature(0) + bytes_of_double(-1e-6) + bytes_of(1'000'000) + bytes_of(1) +
         bytes_of(volts.size()) + samples_of(volts);
}

std::string waveform(double begin, double rate, std::uint64_t downsample,
                     std::initializer_list<float> volts) {
  return bytes_of_double(begin) + bytes_of_double(0) + bytes_of_double(rate) +
         bytes_of(downsample) + bytes_of(volts.size()) + samples_of(volts);
}

Read read_bytes(const std::string& bytes, std::size_t block = one_block) {
  return read_all(open_capture(memory_bytes(bytes, block), "x.bin", at_one_volt));
}

TEST(SaleaeAnalog, Version0_GivesItsEdges) {
  for (const std::size_t block : {std::size_t{1}, std::size_t{5}, one_block}) {
    const Read read = read_bytes(version_0({0.F, 2.F, 2.F, 0.F}), block);
    EXPECT_FALSE(read.error);
    EXPECT_THAT(read.lines, ElementsAre("x"));
    EXPECT_THAT(read.edges, ElementsAre(edge(-1'000'000, 0, '0'), edge(-500'000, 0, '1'),
                                        edge(1'500'000, 0, '0')));
    EXPECT_EQ(read.end_time, microseconds(2));
  }
}

TEST(SaleaeAnalog, Compressed_IsReadInAnyPieces) {
  const std::string bytes = gzip_of(version_0({0.F, 2.F, 2.F, 0.F}));
  for (const std::size_t block : {std::size_t{1}, one_block}) {
    const Read read =
        read_all(open_capture(memory_bytes(bytes, block), "d/MA.bin.gz", at_one_volt));
    EXPECT_FALSE(read.error);
    EXPECT_THAT(read.lines, ElementsAre("MA"));
    EXPECT_EQ(read.edges.size(), 3U);
  }
}

TEST(SaleaeAnalog, SampleRate_IsThatOfAllWaveforms) {
  const auto rate_of_bytes = [](const std::string& bytes) {
    const Opened opened = open_capture(memory_bytes(bytes), "x.bin", at_one_volt);
    if (!opened) return Hertz{};
    while (true) {
      const auto block = (*opened)->next_block();
      if (!block.ok() || block->empty()) return (*opened)->sample_rate();
    }
  };
  const std::string two = signature(1) + bytes_of(2);
  const std::string first = waveform(0, 1e6, 2, {0.F, 2.F});
  EXPECT_EQ(rate_of_bytes(version_0({0.F, 2.F})), megahertz(1));
  EXPECT_EQ(rate_of_bytes(two + first + waveform(1, 1e6, 2, {0.F})), kilohertz(500));
  EXPECT_EQ(rate_of_bytes(two + first + waveform(1, 1e6, 1, {0.F})), Hertz{});
  EXPECT_EQ(rate_of_bytes(two + waveform(0, 1e6, 3, {0.F}) + first), Hertz{});
}

TEST(SaleaeAnalog, Waveforms_AreNotJoined) {
  // 1 MHz sampled down by 2: a sample every 2 us.
  const Read read = read_bytes(signature(1) + bytes_of(2) + waveform(0, 1e6, 2, {0.F, 0.F}) +
                               waveform(1e-3, 1e6, 2, {2.F, 2.F, 0.F}));
  EXPECT_FALSE(read.error);
  EXPECT_THAT(read.edges, ElementsAre(edge(0, 0, '0'), edge(2'000'000, 0, 'x'),
                                      edge(1'000'000'000, 0, '1'), edge(1'003'000'000, 0, '0')));
  EXPECT_EQ(read.end_time, microseconds(1'004));
}

TEST(SaleaeAnalog, SamplesThatAreNoNumbers_AreUnknown) {
  const Read read = read_bytes(version_0({0.F, std::numeric_limits<float>::quiet_NaN(),
                                          std::numeric_limits<float>::infinity(), -3e38F}));
  EXPECT_THAT(read.edges, ElementsAre(edge(-1'000'000, 0, '0'), edge(0, 0, 'x'),
                                      edge(1'000'000, 0, '1'), edge(2'000'000, 0, '0')));
}

TEST(SaleaeAnalog, DamagedFiles_NameTheirCause) {
  const std::string good = version_0({0.F, 2.F, 0.F});
  const Read cut = read_bytes(good.substr(0, good.size() - 2));
  EXPECT_EQ(cut.cause(), CaptureCause::truncated);
  EXPECT_EQ(cut.edges.size(), 2U);
  for (std::size_t bytes = 16; bytes < 48; ++bytes) {
    EXPECT_EQ(read_bytes(good.substr(0, bytes)).cause(), CaptureCause::truncated) << bytes;
  }
  EXPECT_EQ(read_bytes(signature(2) + good.substr(16)).cause(), CaptureCause::unknown_format);
  EXPECT_EQ(read_bytes(version_0({})).cause(), CaptureCause::empty);
  EXPECT_EQ(read_bytes(signature(1) + bytes_of(0)).cause(), CaptureCause::empty);
  const auto version_1 = [](const std::string& waveforms) {
    return read_bytes(signature(1) + bytes_of(2) + waveforms);
  };
  EXPECT_EQ(version_1(waveform(0, 0, 1, {1.F})).cause(), CaptureCause::malformed);
  EXPECT_EQ(version_1(waveform(0, 1e6, 0, {1.F})).cause(), CaptureCause::malformed);
  EXPECT_EQ(version_1(waveform(1e9, 1e6, 1, {1.F})).cause(), CaptureCause::time_out_of_range);
  EXPECT_EQ(version_1(waveform(1, 1e6, 1, {1.F}) + waveform(0, 1e6, 1, {1.F})).cause(),
            CaptureCause::time_backwards);
  EXPECT_EQ(version_1(waveform(0, 1e6, 1, {1.F})).cause(), CaptureCause::truncated);
}

TEST(SaleaeAnalog, WithoutAThreshold_ItIsMeasured) {
  std::vector<wire::Edge> edges{{{}, 0, wire::Level::high}};
  for (int i = 0; i < 40; ++i) {
    edges.push_back({microseconds(2 + i), 0, i % 2 == 0 ? wire::Level::low : wire::Level::high});
  }
  const auto samples = scope_samples(edges, nanoseconds(100), 450, 3);
  for (const std::uint32_t version : {0U, 1U}) {
    const std::string bytes = saleae_analog_text(samples, nanoseconds(100), false, version);
    const Read read = read_all(open_capture(memory_bytes(bytes), "x.bin"));
    EXPECT_FALSE(read.error);
    EXPECT_EQ(read.edges.size(), edges.size());
  }
}

}  // namespace saleae_analog_test
}  // namespace biss::capture
