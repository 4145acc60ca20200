// The channel with a constant format compared with the codec that reads its format at run time.
#include "biss/frame/fixed.hpp"

#include "biss/base/bit_buffer.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"

namespace fixed_test {

using namespace biss;

template <std::size_t N>
struct Text {
  consteval Text(const char (&text)[N]) {
    for (std::size_t i = 0; i < N; ++i) characters[i] = text[i];
  }
  char characters[N]{};
};

template <Text Format>
inline constexpr FrameFormat format_of =
    parse_format(std::string_view(Format.characters, sizeof(Format.characters) - 1)).value();

template <Text Format>
using Fixed = FixedChannel<format_of<Format>.channel_list[0]>;

// A line with only lead, ACK, START, CDS, the payload and STOP.
template <class Channel>
Result<BasicFrame<1>, FrameFault> by_frame(std::uint64_t payload, const FrameFormat& format) {
  BitBuffer<80> line;
  line.append(0b101, 3);
  line.append(false);
  line.append(payload, Channel::total_bits());
  line.append(false);
  return decode_frame(line.view(), FrameCodec<CrcBitwise, 1>(format));
}

// Padding is not restored by encoding and decoding.
template <Text Format, bool Padded = false>
void expect_same_as_frame(std::uint64_t seed) {
  using Channel = Fixed<Format>;
  BISS_RANDOM(random, seed);
  std::uint32_t good = 0;
  for (std::uint32_t i = 0; i < test::rounds(20'000, 200); ++i) {
    std::uint64_t payload = random.bits(Channel::total_bits());
    const std::uint64_t data = payload >> Channel::format().crc.width_bits;
    if (random.flip()) {
      payload = (data << Channel::format().crc.width_bits) |
                CrcBitwise(Channel::format().crc)(data, Channel::format().data_bits);
    }
    const auto fixed = Channel::decode(payload);
    const auto frame = by_frame<Channel>(payload, format_of<Format>);
    BISS_ASSERT_EQ(fixed.ok(), frame.ok()) << "round " << i;
    if (!fixed.ok()) {
      BISS_ASSERT_EQ(fixed.error(), FrameError::crc);
      continue;
    }
    ++good;
    BISS_ASSERT(*fixed == frame->channels()[0]) << "round " << i;
    if (Padded) continue;
    BISS_ASSERT_EQ(Channel::encode(*fixed), payload) << "round " << i;
  }
  BISS_EXPECT(good > test::rounds(5'000, 50));
}

BISS_TEST(FixedChannel, RandomWordsOf24Bits_AsByDecodeFrame) {
  expect_same_as_frame<"pos24,nE,nW,crc6">(0xF1ED);
}

BISS_TEST(FixedChannel, RandomWordsOf36BitsAndCounter_AsByDecodeFrame) {
  expect_same_as_frame<"pos36,nE,nW,lc6,crc16">(0xF1EE);
}

BISS_TEST(FixedChannel, RandomWordsWithMultiturnGrayAndPadding_AsByDecodeFrame) {
  expect_same_as_frame<"mt12,pad3,st23:gray,E,W,crc6", true>(0xF1EF);
}

BISS_TEST(FixedChannel, WordOf64Bits_AsByDecodeFrame) {
  expect_same_as_frame<"pos46,nE,nW,crc16:0x190D9:0x1234">(0xF1F0);
}

BISS_TEST(FixedChannel, BitsAboveThePayload_AreNotLookedAt) {
  using Channel = Fixed<"pos24,nE,nW,crc6">;
  const std::uint64_t word = Channel::encode({.position = 0xABCDEF, .nW = false});
  const auto channel = Channel::decode(word | (~std::uint64_t{0} << Channel::total_bits()));
  BISS_ASSERT(channel.ok());
  BISS_EXPECT_EQ(channel->position, 0xABCDEF);
  BISS_EXPECT(channel->nE);
  BISS_EXPECT(!channel->nW);
}

BISS_TEST(FixedChannel, EveryFlippedBit_IsACrcFault) {
  using Channel = Fixed<"pos24,nE,nW,crc6">;
  static_assert(Channel::decode(Channel::encode({.position = 7}))->position == 7);
  const std::uint64_t word = Channel::encode({.position = 0x123456});
  for (unsigned bit = 0; bit < Channel::total_bits(); ++bit) {
    const auto channel = Channel::decode(word ^ (std::uint64_t{1} << bit));
    BISS_ASSERT(!channel.ok()) << "bit " << bit;
    BISS_EXPECT_EQ(channel.error(), FrameError::crc);
  }
}

// A complete line, with one wrong bit in half of the rounds, decoded with the format as a constant
// and at run time.
template <Text Format>
void expect_same_as_codec(std::uint64_t seed) {
  constexpr FixedCodec<format_of<Format>> fixed;
  using Frame = typename FixedCodec<format_of<Format>>::Frame;
  const FrameCodec<CrcBitwise, 2> codec(format_of<Format>);
  BISS_RANDOM(random, seed);
  for (std::uint32_t i = 0; i < test::rounds(5'000, 60); ++i) {
    Frame sent;
    sent.channel_count = codec.format().channel_count;
    sent.lead_clocks = static_cast<std::uint16_t>(random.below(8) + 1U);
    sent.ack_clocks = static_cast<std::uint16_t>(random.below(160) + 1U);
    for (std::size_t k = 0; k < sent.channel_count; ++k) {
      sent.channel_list[k].position = random.bits(codec.format().channel_list[k].position_bits());
    }
    auto line = encode_frame(sent, fixed);
    BISS_ASSERT(line.ok());
    if (random.flip()) {
      line.value().flip(random.below(static_cast<std::uint32_t>(line->size_bits())));
    }
    const auto one = decode_frame(line->view(), fixed);
    const auto other = decode_frame(line->view(), codec);
    BISS_ASSERT_EQ(one.ok(), other.ok()) << "round " << i;
    if (!one.ok()) {
      BISS_ASSERT(one.error() == other.error()) << "round " << i;
      continue;
    }
    BISS_ASSERT(std::ranges::equal(one->channels(), other->channels())) << "round " << i;
    BISS_ASSERT_EQ(one->ack_clocks, other->ack_clocks) << "round " << i;
    BISS_ASSERT_EQ(one->stop_seen, other->stop_seen) << "round " << i;
  }
}

BISS_TEST(FixedCodec, LinesOf26Bits_AsByFrameCodec) {
  expect_same_as_codec<"pos26,nE,nW,crc6;cds0">(0xF1F1);
}

BISS_TEST(FixedCodec, LinesOfTwoWords_AsByFrameCodec) {
  expect_same_as_codec<"pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16">(0xF1F2);
}

BISS_TEST(FixedCodec, LinesWithoutCrc_AsByFrameCodec) { expect_same_as_codec<"mt4,st60">(0xF1F3); }

}  // namespace fixed_test
