// The channel with constants against the frame codec that reads its format at run time.
#include "biss/frame/fixed.hpp"

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "biss/frame/decode.hpp"
#include "biss/frame/format_parse.hpp"
#include "tests/core/test.hpp"

namespace {

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

// A line with nothing but lead, ACK, START, CDS, the payload and STOP.
template <class Channel>
Result<Frame, FrameFault> by_frame(std::uint64_t payload, const FrameFormat& format) {
  BitBuffer<80> line;
  line.append(0b101, 3);
  line.append(false);
  line.append(payload, Channel::total_bits());
  line.append(false);
  return decode_frame(line.view(), FrameCodec<CrcBitwise, 1>(format));
}

// Padding does not survive the way there and back.
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

}  // namespace

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
