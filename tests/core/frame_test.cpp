#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/test.hpp"

namespace biss::frame_test {

using test::format_of;
using test::frame_of;
using test::line_of;
using test::LineBits;
using SmallCodec = FrameCodec<CrcTable<4>, 2>;

constexpr FrameFormat pos18 = format_of("pos18,nE,nW,crc6;cds0");
constexpr FrameFormat pos18_any_cds = format_of("pos18,nE,nW,crc6");
constexpr FrameFormat safety = format_of("pos28,nE,nW,crc6+pos24,nE,nW,lc6,crc16;cds0");

constexpr bool same_bits(const BitView& a, const BitView& b) {
  if (a.size_bits() != b.size_bits()) return false;
  for (std::size_t i = 0; i < a.size_bits(); ++i) {
    if (a[i] != b[i]) return false;
  }
  return true;
}

template <std::size_t A, std::size_t B>
constexpr bool same_values(const BasicFrame<A>& a, const BasicFrame<B>& b) {
  return a.cds == b.cds && a.lead_clocks == b.lead_clocks && a.ack_clocks == b.ack_clocks &&
         std::ranges::equal(a.channels(), b.channels());
}

template <class Codec>
constexpr bool returns(const Frame& frame, const Codec& codec) {
  const auto bits = encode_frame(frame, codec);
  if (!bits.ok()) return false;
  const auto back = decode_frame(bits->view(), codec);
  return back.ok() && back->stop_seen && same_values(*back, frame);
}

constexpr std::string_view levels_of_12345 = "11 000 1 0 010010001101000101 1 1 001101 0";

static_assert(same_bits(encode_frame(frame_of(0x12345), PlainCodec(pos18))->view(),
                        line_of(levels_of_12345).view()));
static_assert(
    decode_frame(line_of(levels_of_12345).view(), PlainCodec(pos18))->channel_list[0].position ==
    0x12345);
static_assert(returns(frame_of(0x3FFFF, false, true), PlainCodec(pos18)));
static_assert(returns(frame_of(0, true, false), SmallCodec(pos18)));
static_assert(decode_frame(BitView(), PlainCodec(pos18)).error().cause == FrameError::no_response);

/// The result of cause_of() for an accepted frame.
constexpr auto accepted = static_cast<FrameError>(frame_error_count);

template <class Codec>
constexpr FrameError cause_of(BitView bits, const Codec& codec, const FrameBounds& bounds = {}) {
  const auto frame = decode_frame(bits, codec, bounds);
  return frame.ok() ? accepted : frame.error().cause;
}

constexpr FrameError cause_of(std::string_view levels, const FrameBounds& bounds = {}) {
  return cause_of(line_of(levels).view(), PlainCodec(pos18), bounds);
}

/// Decodes with up to four flipped bits in the word and counts accepted frames.
class FlipCounter {
 public:
  explicit FlipCounter(const SmallCodec& codec, const FrameBits& bits, std::size_t first_bit)
      : codec_(codec), bits_(bits), first_bit_(first_bit) {}

  unsigned accepted(unsigned flips, std::size_t below) {
    if (flips == 0) return decode_frame(bits_.view(), codec_).ok() ? 1 : 0;
    unsigned sum = 0;
    for (std::size_t i = flips - 1; i < below; ++i) {
      bits_.flip(first_bit_ + i);
      sum += accepted(flips - 1, i);
      bits_.flip(first_bit_ + i);
    }
    return sum;
  }

 private:
  const SmallCodec& codec_;
  FrameBits bits_;
  std::size_t first_bit_;
};

BISS_TEST(Frame, KnownPosition_HasItsBitsBothWays) {
  const SmallCodec codec(pos18);
  const LineBits line = line_of(levels_of_12345);
  const auto bits = encode_frame(frame_of(0x12345), codec);
  BISS_ASSERT(bits.ok());
  BISS_EXPECT(same_bits(bits->view(), line.view()));
  const auto frame = decode_frame(line.view(), codec);
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0x12345);
  BISS_EXPECT(frame->channel_list[0].nE && frame->channel_list[0].nW);
  BISS_EXPECT_EQ(frame->lead_clocks, 2);
  BISS_EXPECT_EQ(frame->ack_clocks, 3);
  BISS_EXPECT(frame->stop_seen && !frame->cds && frame->trusted());
  BISS_EXPECT_EQ(frame->channels().size(), 1);
}

// The buffer in the comments of two published SPI drivers (VESC, OpenFFBoard), 22 bits.
BISS_TEST(Frame, PublishedSpiBuffer_IsRead) {
  constexpr std::array<std::uint8_t, 8> buffer{0xC0, 0x00, 0x86, 0x74, 0x05, 0xDE, 0x00, 0x00};
  constexpr FrameFormat pos22 = format_of("pos22,nE,nW,crc6;cds0");
  const auto frame = decode_frame(BitView(buffer), SmallCodec(pos22));
  BISS_ASSERT(frame.ok());
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0x067405);
  BISS_EXPECT(frame->trusted() && frame->channel_list[0].nW);
  BISS_EXPECT_EQ(frame->lead_clocks, 2);
  BISS_EXPECT_EQ(frame->ack_clocks, 14);
}

BISS_TEST(Frame, EveryCause_HasItsName) {
  constexpr std::array<std::string_view, frame_error_count> names{
      "no_response", "not_ready", "response_range", "no_start", "ack_range", "truncated",
      "cds",         "crc",       "stop_bit"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    BISS_EXPECT_EQ(name_of(static_cast<FrameError>(i)), names[i]) << "cause " << i;
  }
  BISS_EXPECT_EQ(static_cast<std::size_t>(FrameError::stop_bit) + 1, frame_error_count);
}

BISS_TEST(Frame, DeadLines_ReportNoResponseOrNotReady) {
  BISS_EXPECT_EQ(cause_of(""), FrameError::no_response);
  BISS_EXPECT_EQ(cause_of("1"), FrameError::no_response);
  BISS_EXPECT_EQ(cause_of("11111111111111111111111111111111111111111111"), FrameError::no_response);
  BISS_EXPECT_EQ(cause_of("0"), FrameError::not_ready);
  BISS_EXPECT_EQ(cause_of("00000000000000000000000000000000000000000000"), FrameError::not_ready);
  BISS_EXPECT_EQ(cause_of("0 000 1 0 010010001101000101 1 1 001101 0"), FrameError::not_ready);
}

BISS_TEST(Frame, ResponseOutsideItsBounds_ReportsResponseRange) {
  BISS_EXPECT_EQ(cause_of(levels_of_12345, FrameBounds{.lead_min_clocks = 3}),
                 FrameError::response_range);
  BISS_EXPECT_EQ(cause_of(levels_of_12345, FrameBounds{.lead_max_clocks = 1}),
                 FrameError::response_range);
  BISS_EXPECT_EQ(cause_of("110", FrameBounds{.lead_max_clocks = 1}), FrameError::response_range);
  const LineBits line = line_of(levels_of_12345);
  const FrameBounds exact{2, 2, 3, 3};
  BISS_EXPECT(decode_frame(line.view(), SmallCodec(pos18), exact).ok());
}

BISS_TEST(Frame, AckWithoutStart_ReportsNoStart) {
  BISS_EXPECT_EQ(cause_of("10"), FrameError::no_start);
  BISS_EXPECT_EQ(cause_of("11 000000000000000000000000000000000000000000"), FrameError::no_start);
}

BISS_TEST(Frame, AckOutsideItsBounds_ReportsAckRange) {
  BISS_EXPECT_EQ(cause_of(levels_of_12345, FrameBounds{.ack_min_clocks = 4}),
                 FrameError::ack_range);
  BISS_EXPECT_EQ(cause_of(levels_of_12345, FrameBounds{.ack_max_clocks = 2}),
                 FrameError::ack_range);
}

BISS_TEST(Frame, EveryPrefix_ReportsWhatIsMissing) {
  const SmallCodec codec(pos18);
  const LineBits line = line_of(levels_of_12345);
  const std::size_t without_stop = line.size_bits() - 1;
  for (std::size_t size = 0; size < without_stop; ++size) {
    const FrameError expected = size <= 2   ? FrameError::no_response
                                : size <= 5 ? FrameError::no_start
                                            : FrameError::truncated;
    BISS_EXPECT_EQ(cause_of(line.view().first(size), codec), expected) << "size " << size;
  }
  const auto frame = decode_frame(line.view().first(without_stop), codec);
  BISS_ASSERT(frame.ok());
  BISS_EXPECT(!frame->stop_seen);
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0x12345);
}

BISS_TEST(Frame, CdsOne_IsACauseOnlyWhereItMustBeZero) {
  BISS_EXPECT_EQ(cause_of("11 000 1 1 010010001101000101 1 1 001101 0"), FrameError::cds);
  const LineBits line = line_of("11 000 1 1 010010001101000101 1 1 001101 0");
  const auto frame = decode_frame(line.view(), SmallCodec(pos18_any_cds));
  BISS_ASSERT(frame.ok());
  BISS_EXPECT(frame->cds);
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0x12345);
}

BISS_TEST(Frame, DamagedWord_ReportsCrcBeforeTheStopBit) {
  BISS_EXPECT_EQ(cause_of("11 000 1 0 010010001101000101 1 1 001100 0"), FrameError::crc);
  BISS_EXPECT_EQ(cause_of("11 000 1 0 110010001101000101 1 1 001101 0"), FrameError::crc);
  BISS_EXPECT_EQ(cause_of("11 000 1 0 010010001101000101 0 1 001101 1"), FrameError::crc);
}

BISS_TEST(Frame, StopBitOne_IsReported) {
  BISS_EXPECT_EQ(cause_of("11 000 1 0 010010001101000101 1 1 001101 1"), FrameError::stop_bit);
}

BISS_TEST(Frame, BitsBehindStop_ChangeNothing) {
  const LineBits line = line_of("11 000 1 0 010010001101000101 1 1 001101 0 1110101");
  BISS_EXPECT(decode_frame(line.view(), SmallCodec(pos18)).ok());
}

BISS_TEST(Frame, FlagsOnTheWire_DecideTrust) {
  const SmallCodec codec(pos18);
  for (unsigned flags = 0; flags < 4; ++flags) {
    const Frame sent = frame_of(0x2ABCD, (flags & 2U) != 0, (flags & 1U) != 0);
    BISS_EXPECT(returns(sent, codec)) << "flags " << flags;
    BISS_EXPECT_EQ(sent.trusted(), (flags & 2U) != 0);
  }
}

BISS_TEST(Frame, NullWord_HasAGoodCrcAndIsNotTrusted) {
  const LineBits line = line_of("1 0 1 0 000000000000000000 0 0 111111 0");
  const auto frame = decode_frame(line.view(), SmallCodec(pos18));
  BISS_ASSERT(frame.ok());
  BISS_EXPECT(!frame->trusted());
  BISS_EXPECT(!frame->channel_list[0].nE && !frame->channel_list[0].nW);
}

BISS_TEST(Frame, SeveralChannels_NameTheDamagedOne) {
  const SmallCodec codec(safety);
  Frame sent = frame_of(0x8765432);
  sent.channel_count = 2;
  sent.channel_list[1] = {0x876543, 57, true, false};
  BISS_EXPECT(returns(sent, codec));
  const auto bits = encode_frame(sent, codec);
  BISS_ASSERT(bits.ok());
  const std::size_t word = 2 + 3 + 2;
  for (std::size_t i = 0; i < safety.payload_bits(); ++i) {
    FrameBits hurt = *bits;
    hurt.flip(word + i);
    const auto frame = decode_frame(hurt.view(), codec);
    BISS_ASSERT(!frame.ok()) << "bit " << i;
    BISS_EXPECT_EQ(frame.error().cause, FrameError::crc) << "bit " << i;
    BISS_EXPECT_EQ(frame.error().channel, i < 36 ? 0 : 1) << "bit " << i;
  }
  sent.channel_list[1].nE = false;
  BISS_EXPECT(!sent.trusted());
}

BISS_TEST(Frame, EightChannels_ComeBack) {
  constexpr FrameFormat eight = format_of(
      "pos64,crc16+mt12,st12,nE,nW,crc6+E+pad3,lc32+pos7,crc3+lc6,W,crc5+st9:gray,crc8+mt64");
  const FrameCodec<CrcTable<4>> codec(eight);
  BISS_EXPECT_EQ(codec.payload_bits(), 80 + 32 + 1 + 35 + 10 + 12 + 17 + 64);
  Frame sent;
  sent.channel_count = 8;
  sent.cds = true;
  sent.lead_clocks = 402;
  sent.ack_clocks = 400;
  sent.channel_list = {{{0xFEDCBA9876543210, 0, true, true},
                        {0xA5AFA5, 0, false, true},
                        {0, 0, false, true},
                        {0, 0x89ABCDEF, true, true},
                        {0x55, 0, true, true},
                        {0, 63, true, false},
                        {0x155, 0, true, true},
                        {0x8000000000000001, 0, true, true}}};
  BISS_EXPECT(returns(sent, codec));
}

BISS_TEST(Frame, LongestFrame_Fits) {
  constexpr FrameFormat widest = format_of(
      "pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+pos64,crc16+"
      "pos64,crc16");
  static_assert(widest.payload_bits() == max_payload_bits);
  const FrameCodec<CrcTable<4>> codec(widest);
  Frame sent;
  sent.channel_count = 8;
  sent.lead_clocks = 402;
  sent.ack_clocks = 400;
  for (std::size_t k = 0; k < 8; ++k) sent.channel_list[k].position = ~std::uint64_t{0} << k;
  BISS_EXPECT(returns(sent, codec));
}

BISS_TEST(Frame, EveryAckLength_IsMeasured) {
  const SmallCodec codec(pos18);
  for (std::uint16_t ack = 1; ack <= 400; ++ack) {
    Frame sent = frame_of(ack * 601U % 0x40000U);
    sent.ack_clocks = ack;
    sent.lead_clocks = static_cast<std::uint16_t>(403 - ack);
    BISS_EXPECT(returns(sent, codec)) << "ack " << ack;
  }
}

BISS_TEST(Frame, SmallestFrame_IsOneBit) {
  constexpr FrameFormat flag = format_of("nE");
  const LineBits line = line_of("1 0 1 0 1 0");
  const auto frame = decode_frame(line.view(), PlainCodec(flag));
  BISS_ASSERT(frame.ok());
  BISS_EXPECT(frame->channel_list[0].nE && frame->channel_list[0].nW);
  BISS_EXPECT_EQ(frame->channel_list[0].position, 0);
}

BISS_TEST(Flips, InsideTheWord_PassAsOftenAsTheCodeSays) {
  const SmallCodec codec(pos18);
  const auto bits = encode_frame(frame_of(0x12345), codec);
  BISS_ASSERT(bits.ok());
  FlipCounter counter(codec, *bits, 7);
  BISS_EXPECT_EQ(counter.accepted(0, 26), 1);
  BISS_EXPECT_EQ(counter.accepted(1, 26), 0);
  BISS_EXPECT_EQ(counter.accepted(2, 26), 0);
  BISS_EXPECT_EQ(counter.accepted(3, 26), 40);
}

BISS_TEST(Flips, RandomBits_AreAFrameOrACause) {
  BISS_RANDOM(random, 0xF4A'0001);
  const SmallCodec codec(safety);
  std::array<unsigned, frame_error_count + 1> seen{};
  const std::uint64_t rounds = test::rounds(20'000, 1'000);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::array<std::uint8_t, 20> bytes{};
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits(8));
    const auto part = std::span<const std::uint8_t>(bytes).last(random.below(21));
    const auto frame = decode_frame(BitView(part, random.below(9), 160), codec);
    ++seen[frame.ok() ? frame_error_count : static_cast<std::size_t>(frame.error().cause)];
    BISS_ASSERT(frame.ok() || frame.error().channel < 2);
  }
  BISS_EXPECT(seen[static_cast<std::size_t>(FrameError::truncated)] > 0);
  BISS_EXPECT(seen[static_cast<std::size_t>(FrameError::crc)] > 0);
}

}  // namespace biss::frame_test
