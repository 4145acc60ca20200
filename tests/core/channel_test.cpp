// Writes and reads values in a channel's data word, also values that do not fit.
#include <cstdint>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/test.hpp"

namespace biss {
namespace channel_test {

using test::format_of;
using test::frame_of;
using test::line_of;
using test::LineBits;

// The data word of channel 1 of a frame of one channel without CRC.
constexpr std::uint64_t word_of(const FrameFormat& format, const Channel& values) {
  return pack(format.channel_list[0], values);
}

constexpr Channel reading_of(const FrameFormat& format, std::uint64_t data) {
  return unpack(format.channel_list[0], data);
}

BISS_TEST(Encode, ValuesThatDoNotFit_HaveTheirCauses) {
  constexpr FrameFormat counted = format_of("pos18,nE,nW,lc6,crc6");
  const PlainCodec codec(counted);
  const auto cause = [&codec](const Frame& frame) {
    const auto bits = encode_frame(frame, codec);
    return bits.ok() ? 99U : static_cast<unsigned>(bits.error());
  };
  BISS_EXPECT_EQ(cause(frame_of(0x3FFFF)), 99);
  BISS_EXPECT_EQ(cause(frame_of(0x40000)), static_cast<unsigned>(EncodeError::position_too_large));
  Frame frame = frame_of(1);
  frame.channel_list[0].life_counter = 64;
  BISS_EXPECT_EQ(cause(frame), static_cast<unsigned>(EncodeError::life_counter_too_large));
  frame = frame_of(1);
  frame.channel_count = 2;
  BISS_EXPECT_EQ(cause(frame), static_cast<unsigned>(EncodeError::channel_count));
  BasicFrame<1> too_small;
  too_small.channel_count = 2;
  const auto two = encode_frame(too_small, PlainCodec(format_of("pos18+pos18")));
  BISS_EXPECT(!two.ok() && two.error() == EncodeError::channel_count);
  frame = frame_of(1);
  frame.ack_clocks = 0;
  BISS_EXPECT_EQ(cause(frame), static_cast<unsigned>(EncodeError::ack_range));
  frame.ack_clocks = 401;
  BISS_EXPECT_EQ(cause(frame), static_cast<unsigned>(EncodeError::ack_range));
  frame = frame_of(1);
  frame.lead_clocks = 403;
  BISS_EXPECT_EQ(cause(frame), static_cast<unsigned>(EncodeError::lead_range));
}

BISS_TEST(Encode, ChannelWithoutPositionOrCounter_TakesOnlyZero) {
  constexpr FrameFormat flags = format_of("nE,nW");
  BISS_EXPECT(encode_frame(frame_of(0), PlainCodec(flags)).ok());
  BISS_EXPECT(!encode_frame(frame_of(1), PlainCodec(flags)).ok());
}

BISS_TEST(Channel, FlagsOfBothPolarities_ReadTheSame) {
  constexpr FrameFormat low = format_of("nE,pos3,nW");
  constexpr FrameFormat high = format_of("E,pos3,W");
  for (std::uint64_t data = 0; data < 32; ++data) {
    const Channel from_low = reading_of(low, data);
    BISS_EXPECT_EQ(from_low.nE, (data & 16U) != 0);
    BISS_EXPECT_EQ(from_low.nW, (data & 1U) != 0);
    BISS_EXPECT_EQ(from_low.position, (data >> 1U) & 7U);
    BISS_EXPECT(reading_of(high, data ^ 17U) == from_low) << "data " << data;
    BISS_EXPECT_EQ(word_of(low, from_low), data);
    BISS_EXPECT_EQ(word_of(high, from_low), data ^ 17U);
  }
}

BISS_TEST(Channel, GraySingleturn_StepsByOneBit) {
  constexpr FrameFormat gray = format_of("mt2,st10:gray");
  for (std::uint64_t position = 0; position < 4096; ++position) {
    const std::uint64_t data = word_of(gray, {position, 0, true, true});
    BISS_ASSERT_EQ(reading_of(gray, data).position, position);
    const std::uint64_t st = position & 0x3FFU;
    BISS_ASSERT_EQ(data, (position & 0xC00U) | (st ^ (st >> 1U)));
  }
  constexpr FrameFormat widest = format_of("st64:gray");
  BISS_EXPECT_EQ(word_of(widest, {~std::uint64_t{0}, 0, true, true}), std::uint64_t{1} << 63U);
  BISS_EXPECT_EQ(reading_of(widest, std::uint64_t{1} << 63U).position, ~std::uint64_t{0});
}

BISS_TEST(Channel, MultiturnAndSingleturn_MakeOnePositionInAnyOrder) {
  constexpr Channel values{0xA5AFA5, 0, true, true};
  BISS_EXPECT_EQ(word_of(format_of("mt12,st12"), values), 0xA5AFA5);
  BISS_EXPECT_EQ(word_of(format_of("st12,mt12"), values), 0xFA5A5A);
  BISS_EXPECT_EQ(word_of(format_of("mt12,pad4,st12"), values), 0xA5A0FA5);
  BISS_EXPECT_EQ(reading_of(format_of("st12,mt12"), 0xFA5A5A).position, 0xA5AFA5);
  BISS_EXPECT_EQ(reading_of(format_of("mt24"), 0xA5AFA5).position, 0xA5AFA5);
  BISS_EXPECT_EQ(reading_of(format_of("mt1,st63"), ~std::uint64_t{0}).position, ~std::uint64_t{0});
  BISS_EXPECT_EQ(reading_of(format_of("mt63,st1"), ~std::uint64_t{0}).position, ~std::uint64_t{0});
}

BISS_TEST(Channel, PaddingOfAnyLevel_IsCoveredAndNotJudged) {
  constexpr FrameFormat padded = format_of("pad2,pos3,pad1,nE,crc4");
  const PlainCodec codec(padded);
  for (std::uint64_t data = 0; data < 128; ++data) {
    LineBits line = line_of("1 0 1 0");
    line.append(data, 7);
    line.append(codec.crc(0, data), 4);
    const auto frame = decode_frame(line.view(), codec);
    BISS_ASSERT(frame.ok());
    BISS_EXPECT_EQ(frame->channel_list[0].position, (data >> 2U) & 7U);
    line.flip(4);
    BISS_EXPECT(!decode_frame(line.view(), codec).ok());
  }
}

BISS_TEST(Channel, LifeCounter_CountsThroughItsWidth) {
  constexpr FrameFormat counted = format_of("pos4,lc6,nE");
  for (std::uint32_t count = 0; count < 64; ++count) {
    const std::uint64_t data = word_of(counted, {9, count, true, true});
    BISS_EXPECT_EQ(data, 9U << 7U | count << 1U | 1U);
    BISS_EXPECT_EQ(reading_of(counted, data).life_counter, count);
  }
}

}  // namespace channel_test
}  // namespace biss
