// The fast path of decode_frame() against the plain path, and the combined search for two runs
// against two searches: on good lines, damaged lines and noise.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/base/bits.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"

namespace quick_test {

using namespace biss;

constexpr std::size_t buffer_bytes = 40;

struct Buffer {
  std::array<std::uint8_t, buffer_bytes> bytes{};

  void put(std::size_t at, bool bit) {
    const auto mask = static_cast<std::uint8_t>(0x80U >> (at % 8U));
    auto& byte = bytes[at / 8U];
    byte = static_cast<std::uint8_t>(bit ? byte | mask : byte & ~mask);
  }
};

// Random ones, zeros and a one from `first` on; all other bits are noise.
Buffer runs(test::Random& random, std::size_t first) {
  Buffer buffer;
  for (auto& byte : buffer.bytes) byte = static_cast<std::uint8_t>(random.bits(8));
  const std::size_t ones = random.below(70);
  const std::size_t zeros = random.below(210);
  std::size_t at = first;
  for (std::size_t i = 0; i < ones; ++i) buffer.put(at++, true);
  for (std::size_t i = 0; i < zeros; ++i) buffer.put(at++, false);
  buffer.put(at, true);
  return buffer;
}

BitView random_view(test::Random& random, const Buffer& buffer, std::size_t first) {
  const auto all = static_cast<std::uint32_t>(buffer_bytes * 8U - first);
  return BitView(buffer.bytes, first, random.flip() ? all : random.below(all) + 1U);
}

Result<BasicFrame<2>, FrameFault> step_by_step(const BitView& bits,
                                               const FrameCodec<CrcFast, 2>& codec,
                                               const FrameBounds& bounds) {
  const auto start = frame_detail::search_start(bits, bounds);
  if (!start.ok()) return failure(start.error());
  return decode_payload(bits, *start, codec);
}

void expect_same_frame(const BitView& bits, const FrameCodec<CrcFast, 2>& codec,
                       const FrameBounds& bounds) {
  const auto quick = decode_frame(bits, codec, bounds);
  const auto plain = step_by_step(bits, codec, bounds);
  BISS_ASSERT_EQ(quick.ok(), plain.ok());
  if (!quick.ok()) {
    BISS_EXPECT(quick.error() == plain.error());
    return;
  }
  BISS_EXPECT(quick->channel_list == plain->channel_list);
  BISS_EXPECT_EQ(quick->channel_count, plain->channel_count);
  BISS_EXPECT_EQ(quick->cds, plain->cds);
  BISS_EXPECT_EQ(quick->stop_seen, plain->stop_seen);
  BISS_EXPECT_EQ(quick->lead_clocks, plain->lead_clocks);
  BISS_EXPECT_EQ(quick->ack_clocks, plain->ack_clocks);
  const auto start = find_start(bits, bounds);
  BISS_ASSERT(start.ok());
  BISS_EXPECT_EQ(start->start_bit, plain->lead_clocks + std::size_t{plain->ack_clocks});
}

Buffer damaged_line(test::Random& random, const FrameCodec<CrcFast, 2>& codec) {
  Frame frame;
  frame.channel_count = codec.format().channel_count;
  frame.cds = random.flip();
  frame.lead_clocks = static_cast<std::uint16_t>(random.below(12));
  frame.ack_clocks = static_cast<std::uint16_t>(random.below(200) + 1U);
  for (std::size_t k = 0; k < frame.channel_count; ++k) {
    const ChannelFormat& channel = codec.format().channel_list[k];
    frame.channel_list[k] = {
        .position = random.bits(channel.position_bits()),
        .life_counter = static_cast<std::uint32_t>(random.bits(channel.life_counter.bits)),
        .nE = random.flip(),
        .nW = random.flip()};
  }
  auto line = encode_frame(frame, codec).value();
  const std::uint32_t flips = random.below(3);
  for (std::uint32_t i = 0; i < flips; ++i) {
    line.flip(random.below(static_cast<std::uint32_t>(line.size_bits())));
  }
  Buffer buffer;
  for (std::size_t i = 0; i < line.bytes().size() && i < buffer_bytes; ++i) {
    buffer.bytes[i] = line.bytes()[i];
  }
  return buffer;
}

void sweep(const char* text, std::uint64_t seed) {
  std::size_t size = 0;
  while (text[size] != '\0') ++size;
  const FrameCodec<CrcFast, 2> codec(parse_format(std::string_view(text, size)).value());
  BISS_RANDOM(random, seed);
  for (std::uint32_t i = 0; i < test::rounds(20'000, 100); ++i) {
    const Buffer buffer = damaged_line(random, codec);
    const FrameBounds bounds = random.flip() ? FrameBounds{} : FrameBounds{2, 9, 33, 160};
    expect_same_frame(random_view(random, buffer, 0), codec, bounds);
    expect_same_frame(BitView(buffer.bytes), codec, bounds);
  }
}

BISS_TEST(TwoRuns, AnyPlaceAndLength_AsByTwoSearches) {
  BISS_RANDOM(random, 0x2A00);
  std::uint32_t seen = 0;
  for (std::uint32_t i = 0; i < test::rounds(100'000, 500); ++i) {
    const std::size_t first = random.below(20);
    const Buffer buffer = runs(random, first);
    const BitView bits = random_view(random, buffer, first);
    const auto found = bits.ones_zeros_one();
    if (!found) continue;
    ++seen;
    const std::size_t zeros_at = bits.find(false, 0);
    BISS_ASSERT_EQ(found->ones, zeros_at) << "round " << i;
    BISS_ASSERT_EQ(found->zeros, bits.find(true, zeros_at) - zeros_at) << "round " << i;
  }
  BISS_EXPECT(seen > test::rounds(20'000, 100));
}

BISS_TEST(TwoRuns, EveryLengthThatEndsWithin24Bytes_IsSeen) {
  for (std::size_t first = 0; first < 8; ++first) {
    for (std::size_t ones = 0; ones < 64U - first; ++ones) {
      for (std::size_t zeros = 1; first + ones + zeros < 192; ++zeros) {
        Buffer buffer;
        for (std::size_t i = 0; i < ones; ++i) buffer.put(first + i, true);
        buffer.put(first + ones + zeros, true);
        const auto found = BitView(buffer.bytes, first, 250).ones_zeros_one();
        BISS_ASSERT(found.has_value()) << ones << " ones, " << zeros << " zeros";
        BISS_ASSERT_EQ(found->ones, ones);
        BISS_ASSERT_EQ(found->zeros, zeros);
      }
    }
  }
}

BISS_TEST(TwoRuns, NothingToFind_IsNothing) {
  const std::array<std::uint8_t, 24> zeros{};
  BISS_EXPECT(!BitView(zeros).ones_zeros_one());
  std::array<std::uint8_t, 24> ones{};
  for (auto& byte : ones) byte = 0xFF;
  BISS_EXPECT(!BitView(ones).ones_zeros_one());
  BISS_EXPECT(!BitView().ones_zeros_one());
  std::array<std::uint8_t, 24> late{0x80};
  late[23] = 1;
  BISS_EXPECT(BitView(late).ones_zeros_one().has_value());
  BISS_EXPECT(!BitView(late, 0, 191).ones_zeros_one());
}

BISS_TEST(QuickDecode, DamagedLinesOf26Bits_AsStepByStep) { sweep("pos26,nE,nW,crc6", 0x2A01); }

BISS_TEST(QuickDecode, DamagedLinesWithCds0_AsStepByStep) {
  sweep("pos26,nE,nW,crc6;cds0", 0x2A02);
}

BISS_TEST(QuickDecode, DamagedLinesOf36BitsAndCrc16_AsStepByStep) {
  sweep("lc6,pos30,nE,nW,crc16", 0x2A03);
}

BISS_TEST(QuickDecode, DamagedLinesOfTwoChannels_AsStepByStep) {
  sweep("pos26,nE,nW,crc6+pos18,nE,nW,crc6", 0x2A04);
}

BISS_TEST(QuickDecode, DamagedLinesWithoutCrc_AsStepByStep) { sweep("pos26,nE,nW", 0x2A05); }

BISS_TEST(QuickDecode, DamagedLinesOf64Bits_AsStepByStep) { sweep("pos62,nE,nW,crc6", 0x2A06); }

BISS_TEST(QuickDecode, DamagedLinesOfMultiturnAboveSingleturn_AsStepByStep) {
  sweep("mt12,st23,E,W,crc6", 0x2A07);
}

BISS_TEST(QuickDecode, DamagedLinesOfMultiturnApartFromSingleturn_AsStepByStep) {
  sweep("mt12,pad1,st23,nE,crc6", 0x2A08);
}

BISS_TEST(QuickDecode, DamagedLinesOfMultiturnBehindSingleturn_AsStepByStep) {
  sweep("st20,mt12,nW,crc6", 0x2A09);
}

BISS_TEST(QuickDecode, DamagedLinesOfGray_AsStepByStep) { sweep("st23:gray,nE,nW,crc6", 0x2A0A); }

BISS_TEST(QuickDecode, DamagedLinesOfOneTurnValue_AsStepByStep) {
  sweep("st20,nE,crc5", 0x2A0B);
  sweep("mt20,E,pad3,crc8:0x12F:0x5A", 0x2A0C);
}

BISS_TEST(QuickDecode, DamagedLinesWithoutPosition_AsStepByStep) {
  sweep("pad9,nE,lc32,crc6:0x43:0x3F:plain", 0x2A0D);
}

}  // namespace quick_test
