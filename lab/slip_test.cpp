#include "lab/slip.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/bits.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"

namespace biss {
namespace {

constexpr FrameFormat renishaw18 = *parse_format("pos18,nE,nW,crc6;cds0");

constexpr std::optional<unsigned> none;

// START lost at 18 bits: a position passes if and only if it begins 010.
static_assert(lost_start_halvings<1>(renishaw18, 3) == 3U);
// One bit early or late passes nowhere at Renishaw's widths because the CRC is inverted …
static_assert(early_start_halvings<1>(renishaw18, 1) == none);
static_assert(early_start_halvings<1>(*parse_format("pos18,nE,nW,crc6"), 1) == none);
static_assert(lost_start_halvings<1>(*parse_format("pos36,nE,nW,crc6"), 1, {.cds = true}) == none);
// … and would for half of all words if it were not.
static_assert(early_start_halvings<1>(*parse_format("pos18,nE,nW,crc6:plain"), 1) == 1U);

/// Enumerates all values of a channel's position and counts those that pass with `slip`.
struct Count {
  std::uint64_t accepted = 0;
  std::uint64_t trusted = 0;
};

/// The frame on the line with its slip: what decode_payload() sees from the wrong START on.
Count enumerate(const FrameFormat& format, unsigned bits, int place, unsigned ack, bool cds) {
  const FrameCodec<CrcBitwise, 1> codec(format);
  Count count;
  for (std::uint64_t position = 0; position < (std::uint64_t{1} << bits); ++position) {
    Frame frame;
    frame.channel_count = 1;
    frame.cds = cds;
    frame.lead_clocks = 4;
    frame.ack_clocks = static_cast<std::uint16_t>(ack);
    frame.channel_list[0].position = position;
    FrameBits line = *encode_frame(frame, codec);
    line.append_run(false, 40);
    const std::size_t start = 4 + ack;
    const std::size_t wrong = static_cast<std::size_t>(static_cast<int>(start) + place);
    if (place > 0) {
      line.flip(start);
      if (line.view().find(true, 4) != wrong) continue;
    }
    const auto slipped = decode_payload(line.view(), FrameStart{wrong, 4, 1}, codec);
    if (!slipped.ok()) continue;
    ++count.accepted;
    if (slipped->trusted()) ++count.trusted;
  }
  return count;
}

std::uint64_t words(std::optional<unsigned> halvings, unsigned bits) {
  return halvings ? (std::uint64_t{1} << bits) >> *halvings : 0;
}

void compare(std::string_view text, unsigned bits, bool cds) {
  const FrameFormat format = *parse_format(text);
  const unsigned ack = 6;
  for (int place = -8; place <= static_cast<int>(format.payload_bits()) + 4; ++place) {
    if (place == 0) continue;
    const Count count = enumerate(format, bits, place, ack, cds);
    const Slip slip{.place = place, .ack_clocks = ack};
    const SlipModel model{.cds = cds};
    const SlipModel trusted{.cds = cds, .trusted_only = true};
    EXPECT_EQ(words(slip_halvings<1>(format, slip, model), bits), count.accepted)
        << " at " << place;
    EXPECT_EQ(words(slip_halvings<1>(format, slip, trusted), bits), count.trusted)
        << " at " << place;
  }
}

}  // namespace

TEST(Slip, AllPositionsOfSmallFormats_AgreeWithTheCount) {
  const unsigned bits = 10U;
  const std::string_view narrow = bits == 10 ? "pos10,nE,nW,crc4" : "pos5,nE,nW,crc4";
  const std::string_view plain = bits == 10 ? "pos10,crc3:0x0B:plain" : "pos5,crc3:0x0B:plain";
  const std::string_view start =
      bits == 10 ? "E,pad2,pos10,W,crc5:0x25:0x13" : "E,pad2,pos5,W,crc5:0x25:0x13";
  const std::string_view bare = bits == 10 ? "pad1,pos10,nE;cds0" : "pad1,pos5,nE;cds0";
  for (const bool cds : {false, true}) {
    compare(narrow, bits, cds);
    compare(plain, bits, cds);
    compare(start, bits, cds);
  }
  compare(bare, bits, false);
}

TEST(Slip, EvenlyDistributedFlags_CountAsData) {
  const FrameFormat flags = *parse_format("pos6,nE,nW,crc3");
  const FrameFormat data = *parse_format("pos8,crc3");
  for (int place = -12; place < 16; ++place) {
    if (place == 0) continue;
    const Slip slip{.place = place, .ack_clocks = 5};
    EXPECT_TRUE(slip_halvings<1>(flags, slip, {.healthy_flags = false}) ==
                slip_halvings<1>(data, slip));
  }
}

TEST(Slip, TailChecked_LeavesFewerEarlyStarts) {
  // A START in ACK leaves its last bits behind the STOP that is seen.
  EXPECT_TRUE(early_start_halvings<1>(renishaw18, 12) == 7U);
  EXPECT_TRUE(early_start_halvings<1>(renishaw18, 12, {.tail_checked = true}) == none);
  EXPECT_TRUE(early_start_halvings<1>(renishaw18, 3, {.tail_checked = true}) == 3U);
  // Behind a late START there is nothing but zeros.
  EXPECT_TRUE(lost_start_halvings<1>(renishaw18, 3, {.tail_checked = true}) == 3U);
}

TEST(Slip, TrustedOnly_AsksForNoError) {
  EXPECT_TRUE(lost_start_halvings<1>(renishaw18, 3, {.trusted_only = true}) == 4U);
}

TEST(Slip, OnesBehindALostAck_AreRequired) {
  // CDS 0 cannot extend the leading ones; CDS 1 must.
  const FrameFormat format = *parse_format("pos8,crc3");
  unsigned possible = 0;
  for (int place = 3; place < 12; ++place) {
    const Slip one{.place = place, .ones_clocks = 1};
    EXPECT_TRUE(slip_halvings<1>(format, one) == none);
    EXPECT_TRUE(slip_halvings<1>(format, {.place = place}, {.cds = true}) == none);
    if (slip_halvings<1>(format, one, {.cds = true})) ++possible;
  }
  EXPECT_TRUE(possible != 0);
}

TEST(Slip, TwoChannels_NeedBothChecksums) {
  const FrameFormat one = *parse_format("pos12,nE,nW,crc6");
  const FrameFormat two = *parse_format("pos12,nE,nW,crc6+pos12,nE,nW,lc6,crc16");
  for (unsigned distance = 1; distance < 30; ++distance) {
    const auto single = lost_start_halvings<1>(one, distance);
    const auto both = lost_start_halvings<2>(two, distance);
    EXPECT_TRUE(!both || !single || *both > *single) << " at " << distance;
    EXPECT_TRUE(both == lost_start_halvings<3>(two, distance)) << " at " << distance;
  }
}

TEST(Slip, WordsOfOnePosition_AreCountedOnce) {
  const FrameFormat format = *parse_format("pos4,crc3+pos3,lc2,crc3");
  // Both words begin with the same three bits: enumerated in tests/spi, here against a pair where
  // the second word is all its own.
  const FrameFormat apart = *parse_format("pos4,crc3+lc5,crc3");
  unsigned different = 0;
  for (int place = -12; place < 16; ++place) {
    if (place == 0) continue;
    const Slip slip{.place = place, .ack_clocks = 20};
    const SlipModel aligned{.aligned_words = true};
    EXPECT_TRUE(slip_halvings<2>(apart, slip, aligned) == slip_halvings<2>(apart, slip));
    EXPECT_TRUE(slip_halvings<2>(apart, slip) == slip_halvings<2>(format, slip));
    if (slip_halvings<2>(format, slip, aligned) != slip_halvings<2>(format, slip)) ++different;
  }
  EXPECT_TRUE(different != 0);
}

}  // namespace biss
