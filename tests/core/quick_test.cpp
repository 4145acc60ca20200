// The fast path of decode_frame() and SpiReader against the plain path, and the searches by words
// against searches bit by bit: on good lines, damaged lines and noise, in buffers of any length.
#include "biss/base/bits.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/test.hpp"

namespace quick_test {

using namespace biss;

constexpr std::size_t buffer_bytes = 40;

// Steps of a sweep on the host, and under emulation.
constexpr std::size_t steps(std::size_t host, std::size_t target) {
  return static_cast<std::size_t>(test::rounds(host, target));
}

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

template <class Codec>
using Outcome = frame_detail::Outcome<Codec>;

template <class Codec>
Outcome<Codec> step_by_step(const BitView& bits, const Codec& codec, const FrameBounds& bounds) {
  Outcome<Codec> result = typename Codec::Frame{};
  const auto start = frame_detail::search_start(bits, bounds);
  if (!start.ok()) return failure(start.error());
  const auto fault = frame_detail::read_payload(bits, *start, codec, result.value());
  if (fault) result = failure(*fault);
  return result;
}

template <class Outcome>
void expect_same_outcome(const Outcome& quick, const Outcome& plain) {
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
}

template <class Codec>
void expect_same_frame(const BitView& bits, const Codec& codec, const FrameBounds& bounds) {
  expect_same_outcome(decode_frame(bits, codec, bounds), step_by_step(bits, codec, bounds));
  const auto start = find_start(bits, bounds);
  const auto plain = frame_detail::search_start(bits, bounds);
  BISS_ASSERT_EQ(start.ok(), plain.ok());
  if (!start.ok()) {
    BISS_EXPECT(start.error() == plain.error());
    return;
  }
  BISS_EXPECT_EQ(start->start_bit, plain->start_bit);
  BISS_EXPECT_EQ(start->lead_clocks, plain->lead_clocks);
  BISS_EXPECT_EQ(start->ack_clocks, plain->ack_clocks);
}

constexpr FrameFormat format_of(std::string_view text) { return parse_format(text).value(); }

template <class Codec>
Buffer damaged_line(test::Random& random, const Codec& codec) {
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

void sweep(std::string_view text, std::uint64_t seed) {
  const FrameCodec<CrcFast, 2> codec(format_of(text));
  BISS_RANDOM(random, seed);
  for (std::uint32_t i = 0; i < test::rounds(20'000, 100); ++i) {
    const Buffer buffer = damaged_line(random, codec);
    const FrameBounds bounds = random.flip() ? FrameBounds{} : FrameBounds{2, 9, 33, 160};
    expect_same_frame(random_view(random, buffer, 0), codec, bounds);
    expect_same_frame(BitView(buffer.bytes), codec, bounds);
    Buffer at_end;
    const auto bytes = std::span<std::uint8_t>(at_end.bytes).last(i % (buffer_bytes + 1U));
    for (std::size_t k = 0; k < bytes.size(); ++k) bytes[k] = buffer.bytes[k];
    expect_same_frame(BitView(bytes), codec, bounds);
    for (auto& byte : at_end.bytes) byte = static_cast<std::uint8_t>(random.bits(8));
    expect_same_frame(BitView(bytes), codec, bounds);
  }
}

BISS_TEST(BitsByWords, AnyPlaceAndLength_AsBitByBit) {
  BISS_RANDOM(random, 0x2A00);
  std::uint32_t found = 0;
  for (std::uint32_t i = 0; i < test::rounds(100'000, 500); ++i) {
    const std::size_t first = random.below(20);
    const Buffer buffer = runs(random, first);
    const BitView bits = random_view(random, buffer, first);
    const std::size_t known = bits.stored().size() < 4 ? 0 : bits.head_bits();
    for (std::size_t k = 0; k < known && k < bits.size_bits(); ++k) {
      BISS_ASSERT_EQ((bits.head() >> (63U - k)) & 1U, bits[k]) << "round " << i << " bit " << k;
    }
    std::size_t one = bits.head_bits();
    while (one < bits.size_bits() && !bits[one]) ++one;
    if (one > bits.size_bits()) continue;
    BISS_ASSERT_EQ(bits.find_one_after_head(), one) << "round " << i;
    found += one < bits.size_bits() ? 1U : 0U;
  }
  BISS_EXPECT(found > test::rounds(20'000, 100));
}

BISS_TEST(BitsByWords, OnlyOneInAnyPlace_IsSeenUnlessItIsOutside) {
  for (std::size_t size = 1; size <= buffer_bytes; size += steps(1, 3)) {
    for (std::size_t one = 0; one < 8 * size; one += steps(1, 5)) {
      Buffer buffer;
      buffer.put(8 * (buffer_bytes - size) + one, true);
      const auto bytes = std::span<const std::uint8_t>(buffer.bytes).last(size);
      BISS_ASSERT_EQ(BitView(bytes).ones_after_8_bytes() == 0, one < 64) << size << ", " << one;
      for (std::size_t from = 0; from <= 8 * size; from += steps(1, 7)) {
        BISS_ASSERT_EQ(BitView(bytes).is_low_from(from), one < from) << size << ", " << one;
      }
      const BitView inside(bytes, 3, 8 * size - 8);
      const std::size_t end = 3 + inside.size_bits();
      for (std::size_t from = 0; from < inside.size_bits(); from += steps(1, 11)) {
        BISS_ASSERT_EQ(inside.is_low_from(from), one < 3 + from || one >= end)
            << size << ", " << one;
      }
    }
  }
}

// A good frame of every lead and ACK in buffers of every length, whole or cut, whose end is that of
// the storage.
template <class Codec>
void sweep_places(const Codec& codec) {
  Frame frame;
  frame.channel_count = codec.format().channel_count;
  for (std::size_t k = 0; k < frame.channel_count; ++k) {
    const ChannelFormat& channel = codec.format().channel_list[k];
    frame.channel_list[k].position = 0x5A5A'1234'8765'4321U & low_mask(channel.position_bits());
  }
  // Short ones, and those that end near the end of a word.
  constexpr std::array<std::uint16_t, 9> leads{1, 3, 7, 31, 32, 33, 63, 64, 65};
  for (const std::uint16_t lead : leads) {
    for (std::uint16_t ack = 1; ack < 300; ack = static_cast<std::uint16_t>(ack + steps(1, 13))) {
      frame.lead_clocks = lead;
      frame.ack_clocks = ack;
      const auto line = encode_frame(frame, codec).value();
      for (std::size_t size = 0; size <= buffer_bytes; size += steps(1, 5)) {
        Buffer buffer;
        const auto bytes = std::span<std::uint8_t>(buffer.bytes).last(size);
        for (std::size_t i = 0; i < size && i < line.bytes().size(); ++i)
          bytes[i] = line.bytes()[i];
        expect_same_frame(BitView(bytes), codec, {});
        expect_same_frame(BitView(bytes, 0, line.size_bits() - ack % 3U), codec, {});
        expect_same_frame(BitView(bytes, 1, 8 * size), codec, {});
      }
    }
  }
}

// The reader's rule, with the tail bit by bit.
template <class Codec>
Outcome<Codec> read_step_by_step(const SpiReader<Codec>& reader, std::size_t first_bit,
                                 std::size_t low_until, std::span<const std::uint8_t> bytes,
                                 std::size_t clocks) {
  const BitView bits(bytes, first_bit, clocks);
  const auto frame = step_by_step(bits, reader.codec(), reader.bounds());
  if (!frame.ok()) return frame;
  const std::size_t from =
      std::size_t{frame->lead_clocks} + frame->ack_clocks + 3U + reader.codec().payload_bits();
  for (std::size_t i = from; i < bits.size_bits() && i < low_until; ++i) {
    if (bits[i]) return failure(FrameFault{FrameError::stop_bit});
  }
  return frame;
}

template <class Codec>
void sweep_reader(const Codec& codec, std::uint64_t seed) {
  BISS_RANDOM(random, seed);
  for (std::uint32_t i = 0; i < test::rounds(40'000, 200); ++i) {
    SpiSetup setup{.period = nanoseconds(100), .line_delay = {.max = nanoseconds(700)}};
    if (random.below(4) == 0) setup.first_bit = static_cast<std::uint16_t>(random.below(17));
    if (random.below(4) == 0) setup.tail = SpiTail::ignored;
    DeviceTiming timing{.ack_max = nanoseconds(16'000)};
    if (random.below(4) == 0) {
      timing.timeout = {TimeoutRule::cycle, nanoseconds(100) * (1 + random.below(300))};
    }
    std::size_t low_until = std::numeric_limits<std::uint16_t>::max();
    if (timing.timeout.rule == TimeoutRule::cycle) {
      low_until = static_cast<std::size_t>(timing.timeout.time.count / setup.period.count);
    }
    if (setup.tail == SpiTail::ignored) low_until = 0;
    const SpiReader<Codec> reader(codec, setup, timing);
    Buffer buffer = damaged_line(random, codec);
    if (random.below(4) == 0) buffer.put(random.below(8 * buffer_bytes), true);
    const std::size_t size = random.below(buffer_bytes + 1U);
    Buffer at_end;
    const auto bytes = std::span<std::uint8_t>(at_end.bytes).last(size);
    for (std::size_t k = 0; k < size; ++k) bytes[k] = buffer.bytes[k];
    const std::size_t clocks = random.flip() ? 8 * buffer_bytes : random.below(330);
    expect_same_outcome(reader.read(bytes, clocks),
                        read_step_by_step(reader, setup.first_bit, low_until, bytes, clocks));
  }
}

constexpr FrameFormat one_channel = format_of("pos26,nE,nW,crc6");
constexpr FrameFormat two_channels = format_of("pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16;cds0");

BISS_TEST(QuickDecode, EveryLeadAckAndLengthOf22Bits_AsStepByStep) {
  sweep_places(FrameCodec<CrcFast, 1>(format_of("pos22,nE,nW,crc6")));
}

BISS_TEST(QuickDecode, EveryLeadAckAndLengthOf26Bits_AsStepByStep) {
  sweep_places(FixedCodec<one_channel>{});
}

BISS_TEST(QuickDecode, EveryLeadAckAndLengthOf36Bits_AsStepByStep) {
  sweep_places(FrameCodec<CrcFast, 2>(format_of("pos36,nE,nW,crc6")));
}

BISS_TEST(QuickDecode, EveryLeadAckAndLengthOfTwoChannels_AsStepByStep) {
  sweep_places(FrameCodec<CrcFast, 2>(two_channels));
}

BISS_TEST(QuickDecode, EveryLeadAckAndLengthOfTwoFixedChannels_AsStepByStep) {
  sweep_places(FixedCodec<two_channels>{});
}

BISS_TEST(QuickRead, AnySetupAndBufferOf26Bits_AsStepByStep) {
  sweep_reader(FrameCodec<CrcFast, 1>(one_channel), 0x2A10);
}

BISS_TEST(QuickRead, AnySetupAndBufferOf26FixedBits_AsStepByStep) {
  sweep_reader(FixedCodec<one_channel>{}, 0x2A11);
}

BISS_TEST(QuickRead, AnySetupAndBufferOfTwoChannels_AsStepByStep) {
  sweep_reader(FrameCodec<CrcFast, 2>(two_channels), 0x2A12);
}

BISS_TEST(QuickRead, AnySetupAndBufferOfTwoFixedChannels_AsStepByStep) {
  sweep_reader(FixedCodec<two_channels>{}, 0x2A13);
}

// With cds0, CRC16, two channels, no CRC, 64 bits; turns above, apart from and after the singleturn;
// Gray code, one value of the turn, no position.
BISS_TEST(QuickDecode, DamagedLines_AsStepByStep) {
  constexpr std::array<std::string_view, 13> formats{"pos26,nE,nW,crc6",
                                                     "pos26,nE,nW,crc6;cds0",
                                                     "lc6,pos30,nE,nW,crc16",
                                                     "pos26,nE,nW,crc6+pos18,nE,nW,crc6",
                                                     "pos26,nE,nW",
                                                     "pos62,nE,nW,crc6",
                                                     "mt12,st23,E,W,crc6",
                                                     "mt12,pad1,st23,nE,crc6",
                                                     "st20,mt12,nW,crc6",
                                                     "st23:gray,nE,nW,crc6",
                                                     "st20,nE,crc5",
                                                     "mt20,E,pad3,crc8:0x12F:0x5A",
                                                     "pad9,nE,lc32,crc6:0x43:0x3F:plain"};
  for (std::size_t i = 0; i < formats.size(); ++i) sweep(formats[i], 0x2A01 + i);
}

}  // namespace quick_test
