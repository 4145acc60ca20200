// Writes and reads values in a channel's data word, also values that do not fit.
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/test.hpp"

namespace biss::channel_test {

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

BISS_TEST(Channel, GrayOrLowestBitFirst_ReadsBack) {
  BISS_EXPECT_EQ(word_of(format_of("pos4:lsb"), {0b0010, 0, true, true}), 0b0100U);
  BISS_EXPECT_EQ(word_of(format_of("pos4:gray"), {0b0010, 0, true, true}), 0b0011U);
  BISS_EXPECT_EQ(word_of(format_of("pos4:gray:lsb"), {0b0010, 0, true, true}), 0b1100U);
  // The turns and the position within a turn are numbers of their own.
  BISS_EXPECT_EQ(word_of(format_of("mt4:gray,st4:gray"), {0x28, 0, true, true}), 0b0011'1100U);
  BISS_EXPECT_EQ(word_of(format_of("mt4:lsb,st4"), {0x21, 0, true, true}), 0x41U);
  for (const char* text : {"pos10:gray", "pos10:lsb,nE", "mt3:gray,st7:lsb", "mt5:lsb,nW,st5:gray",
                           "st4:gray:lsb,mt6:gray:lsb", "mt10:gray:lsb"}) {
    const FrameFormat format = format_of(text);
    for (std::uint64_t position = 0; position < 1024; ++position) {
      const Channel values{position, 0, true, true};
      BISS_ASSERT(reading_of(format, word_of(format, values)) == values) << text << position;
    }
  }
}

// As transmitted, bit by bit from what the suffix says; without a suffix, by the usual codec.
std::uint64_t usual_crc(const char* text, std::uint64_t data) {
  return PlainCodec(format_of(text)).crc(0, data, false);
}

BISS_TEST(Channel, ChecksumWithAnErrorOfTheMaker_IsThatOfTheSuffix) {
  constexpr std::uint64_t data = 0b1100'1010'01;  // pos8, nE = 0, nW = 1
  const auto crc = [](const char* text, bool cds) {
    return std::uint64_t{PlainCodec(format_of(text)).crc(0, data, cds)};
  };
  const std::uint64_t usual = usual_crc("pos8,nE,nW,crc6", data);
  BISS_EXPECT_EQ(crc("pos8,nE,nW,crc6:reversed", true), frame_detail::bits_reversed(usual, 6));
  BISS_EXPECT_EQ(crc("pos8,nE,nW,crc6:no-flags", true), usual_crc("pos8,crc6", data >> 2U));
  BISS_EXPECT_EQ(crc("nE,pos8,nW,crc6:no-flags", false),
                 usual_crc("pos8,crc6", (data >> 1U) & 0xFFU));
  BISS_EXPECT_EQ(crc("pos8,nE,nW,crc6:cds", false), usual_crc("pad1,pos10,crc6", data));
  BISS_EXPECT_EQ(crc("pos8,nE,nW,crc6:cds", true), usual_crc("pad1,pos10,crc6", data | 0x400U));
  BISS_EXPECT_EQ(
      crc("pos8,nE,nW,crc6:0x43:0x15:plain:reversed:no-flags", true),
      frame_detail::bits_reversed(usual_crc("pos8,crc6:0x43:0x15:plain", data >> 2U), 6));
  // 65 bits are covered.
  const PlainCodec widest(format_of("pos64,crc16:cds"));
  BISS_EXPECT(widest.crc(0, 1, true) != widest.crc(0, 1, false));
}

BISS_TEST(Decode, ChecksumWithAnErrorOfTheMaker_ReadsItsOwnFramesOnly) {
  for (const char* text :
       {"pos18,nE,nW,crc6:reversed", "pos18,nE,nW,crc6:no-flags", "pos18,nE,nW,crc6:cds",
        "pos18,nE,nW,crc6:reversed:no-flags:cds", "mt8:gray,st24:lsb,nE,nW,crc16:reversed",
        "pos20,crc6+pos18,nE,nW,crc6:cds"}) {
    const FrameFormat format = format_of(text);
    const FrameCodec<> codec(format);
    Frame frame = frame_of(0x2ABCD);
    frame.channel_count = format.channel_count;
    frame.channel_list[1] = frame.channel_list[0];
    frame.channel_list[0].nE = format.channel_count == 2;
    frame.cds = true;
    const auto bits = encode_frame(frame, codec);
    BISS_ASSERT(bits.ok());
    const auto read = decode_frame(bits->view(), codec);
    BISS_ASSERT(read.ok()) << text;
    BISS_EXPECT(read->channel_list[0] == frame.channel_list[0]) << text;
    for (std::size_t at = 4; at < 4 + codec.payload_bits(); ++at) {
      LineBits wrong;
      wrong.append(bits->view());
      wrong.flip(at);
      const auto refused = decode_frame(wrong.view(), codec);
      // A flag that no CRC covers can change.
      const bool uncovered = refused.ok() && refused->channel_list[0].position == 0x2ABCD;
      BISS_EXPECT(!refused.ok() || uncovered) << text << " at " << at;
    }
    FrameFormat usual = format;
    for (ChannelFormat& channel : usual.channel_list) {
      channel.crc.reversed = channel.crc.without_flags = channel.crc.with_cds = false;
    }
    BISS_EXPECT(!decode_frame(bits->view(), FrameCodec<>(usual)).ok()) << text;
  }
}

BISS_TEST(Decode, ChecksumOfTheFrameBefore_IsNeverPassed) {
  const FrameFormat format = format_of("pos18,nE,nW,crc6:previous");
  const FrameCodec<> codec(format);
  const auto encoded = encode_frame(frame_of(5), codec);
  BISS_EXPECT(!encoded.ok() && encoded.error() == EncodeError::needs_previous);
  for (std::uint64_t crc = 0; crc < 64; ++crc) {
    LineBits line = line_of("1 0 1 0");
    line.append(5U << 2U | 3U, 20);
    line.append(crc << 1U, 7);
    BISS_EXPECT(decode_frame(line.view(), codec).error() == FrameFault{FrameError::crc});
  }
  const FrameFormat padded = format.without_previous();
  BISS_EXPECT_EQ(format_text(padded).view(), std::string_view("pos18,nE,nW,pad6"));
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
    line.append(codec.crc(0, data, false), 4);
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

}  // namespace biss::channel_test
