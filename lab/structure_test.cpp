#include "lab/structure.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"
#include "lab/test_slip.hpp"

namespace biss::lab {
namespace structure_test {

using Levels = std::vector<bool>;

FrameFormat format_of(std::string_view text) {
  const auto format = parse_format(text);
  EXPECT_TRUE(format.ok()) << text;
  return *format;
}

void append(Levels& line, std::uint64_t value, unsigned bits) {
  for (unsigned i = bits; i-- > 0;) line.push_back(((value >> i) & 1U) != 0);
}

std::uint64_t taken(const Levels& line, std::size_t at, unsigned bits) {
  std::uint64_t value = 0;
  for (unsigned i = 0; i < bits; ++i) value = (value << 1U) | (line[at + i] ? 1U : 0U);
  return value;
}

// Zeros of ACK, then the frame from START on, then zeros.
constexpr std::size_t ack = 60;

struct Truth {
  std::uint64_t position;
  std::uint64_t counter;
};

Levels line_of(const FrameFormat& format, const Truth& truth, bool aligned) {
  Levels line(ack, false);
  append(line, 0b10, 2);
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    const ChannelFormat& channel = format.channel_list[k];
    const unsigned first_bits = format.channel_list[0].position.bits;
    std::uint64_t position = truth.position;
    if (k != 0 && aligned) position >>= first_bits - channel.position.bits;
    const std::uint64_t data = channel.position.placed(position) | channel.error.placed(true) |
                               channel.warning.placed(true) |
                               channel.life_counter.placed(truth.counter);
    append(line, data, channel.data_bits);
    append(line, CrcBitwise(channel.crc)(data, channel.data_bits), channel.crc.width_bits);
  }
  line.resize(line.size() + 200, false);
  return line;
}

// Damages the line. Returns where START is read then.
std::size_t damage(Levels& line, FaultKind fault, unsigned place, unsigned gap_bits) {
  const auto at = line.begin() + static_cast<std::ptrdiff_t>(ack + place);
  switch (fault) {
    case FaultKind::lost_bit:
      line.erase(at);
      break;
    case FaultKind::doubled_bit:
      line.insert(at, bool{*at});
      break;
    case FaultKind::inserted_low:
    case FaultKind::inserted_high:
      line.insert(at, fault == FaultKind::inserted_high);
      break;
    case FaultKind::slo_low:
    case FaultKind::slo_high:
      std::fill(at, line.end(), fault == FaultKind::slo_high);
      break;
    case FaultKind::gap_low:
    case FaultKind::gap_high:
      std::fill(at, at + gap_bits, fault == FaultKind::gap_high);
      break;
    case FaultKind::lost_start:
      line[ack] = false;
      break;
    case FaultKind::false_start:
      line[ack - place] = true;
      break;
    default:
      break;
  }
  std::size_t start = 0;
  while (start < line.size() && !line[start]) ++start;
  return start;
}

struct Level {
  bool first_word, all_words, trusted, pair;
};

Level judged(const FrameFormat& format, const Levels& line, std::size_t start, const Truth& truth,
             const StructureModel& model) {
  std::size_t at = start + 2;
  if (line.size() < start + format.payload_bits() + 3) return {};
  if (format.cds0 && line[start + 1]) return {};
  if (line[start + 2 + format.payload_bits()]) return {};
  std::vector<bool> good;
  std::vector<std::uint64_t> words;
  for (const ChannelFormat& channel : format.channels()) {
    words.push_back(taken(line, at, channel.data_bits));
    at += channel.data_bits;
    const std::uint64_t check = taken(line, at, channel.crc.width_bits);
    at += channel.crc.width_bits;
    good.push_back(CrcBitwise(channel.crc)(words.back(), channel.data_bits) == check);
  }
  const auto& channels = format.channel_list;
  const std::uint64_t position = channels[0].position.of(words[0]);
  Level level{};
  level.first_word = good[0] && position != truth.position;
  level.all_words = level.first_word;
  level.trusted = true;
  for (std::size_t k = 0; k < words.size(); ++k) {
    level.all_words = level.all_words && good[k];
    level.trusted = level.trusted && channels[k].error.low_active(words[k]);
  }
  level.trusted = level.trusted && level.all_words;
  if (!model.pair) return level;
  const unsigned both = channels[1].position.bits;
  const unsigned bits = model.comparison.compare_bits == 0 ? both : model.comparison.compare_bits;
  const std::uint64_t range = std::uint64_t{1} << bits;
  const std::uint64_t a = position >> (channels[0].position.bits - bits);
  const std::uint64_t b = channels[1].position.of(words[1]) >> (both - bits);
  const std::uint64_t up = (a + range - b) % range;
  const unsigned tolerance = model.comparison.tolerance_lsb;
  level.pair = level.trusted && (up <= tolerance || range - up <= tolerance) &&
               channels[1].life_counter.of(words[1]) == truth.counter;
  return level;
}

// The sum of the last level's shares: 0 where it was never reached.
long double expect_counted(std::string_view text, const StructureModel& model) {
  SCOPED_TRACE(text);
  const FrameFormat format = format_of(text);
  const unsigned position_bits = format.channel_list[0].position.bits;
  const unsigned counter_bits = model.pair ? format.channel_list[1].life_counter.bits : 0U;
  const auto all = static_cast<long double>(std::uint64_t{1} << (position_bits + counter_bits));
  long double any = 0;
  for (const FaultKind fault : structural_faults) {
    StructureRow row;
    for (unsigned place = 1; place < format.payload_bits() + 2; ++place) {
      PassedShares counted;
      for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(all); ++i) {
        const Truth truth{i >> counter_bits, i & low_mask(counter_bits)};
        Levels line = line_of(format, truth, model.pair);
        const std::size_t start = damage(line, fault, place, model.gap_bits);
        if (fault == FaultKind::lost_start && start != ack + place) continue;
        const Level level = judged(format, line, start, truth, model);
        counted.first_word += level.first_word ? 1 : 0;
        counted.all_words += level.all_words ? 1 : 0;
        counted.trusted += level.trusted ? 1 : 0;
        counted.pair += level.pair ? 1 : 0;
      }
      const PassedShares found = passed_shares(format, fault, place, model);
      EXPECT_EQ(found.first_word, counted.first_word / all) << name_of(fault) << " " << place;
      EXPECT_EQ(found.all_words, counted.all_words / all) << name_of(fault) << " " << place;
      EXPECT_EQ(found.trusted, counted.trusted / all) << name_of(fault) << " " << place;
      EXPECT_EQ(found.pair, counted.pair / all) << name_of(fault) << " " << place;
      any += model.pair ? found.pair : found.trusted;
      row.sum.first_word += found.first_word;
    }
    EXPECT_EQ(structure_row(format, fault, model).sum.first_word, row.sum.first_word);
  }
  return any;
}

TEST(Structure, OneWord_IsWhatCountingFinds) {
  long double any = 0;
  any += expect_counted("pos9,nE,nW,crc4;cds0", {.gap_bits = 4});
  any += expect_counted("pos9,nE,nW,crc4", {.gap_bits = 3});
  any += expect_counted("nE,pos8,crc3:plain", {.gap_bits = 2});
  any += expect_counted("pos9,E,W,crc5:0x25:0x1A;cds0", {});
  EXPECT_GT(any, 0);
}

TEST(Structure, TwoWords_AreWhatCountingFinds) {
  long double any = 0;
  any += expect_counted("pos7,nE,nW,crc3+pos5,nE,nW,lc2,crc4;cds0", {.pair = true, .gap_bits = 3});
  any += expect_counted("pos7,nE,nW,crc3+pos5,nE,nW,lc2,crc4",
                        {.pair = true, .comparison = {.compare_bits = 3}, .gap_bits = 5});
  any += expect_counted("pos6,nE,nW,crc3:plain+pos6,nE,lc2,crc3:plain",
                        {.pair = true, .comparison = {.tolerance_lsb = 0}, .gap_bits = 3});
  EXPECT_GT(any, 0);
}

TEST(Structure, LostAndFalseStart_AreSlips) {
  for (const char* const text : {"pos18,nE,nW,crc6;cds0", "pos26,nE,nW,crc6;cds0",
                                 "pos32,nE,nW,crc6;cds0", "pos36,nE,nW,crc6;cds0"}) {
    const FrameFormat format = format_of(text);
    for (unsigned place = 1; place < format.payload_bits(); ++place) {
      const auto expect = [&](FaultKind fault, std::optional<unsigned> conditions) {
        const long double passed =
            conditions ? std::ldexp(1.0L, -static_cast<int>(*conditions)) : 0;
        const long double found = passed_shares(format, fault, place, {}).all_words;
        // Slips count what passes with the right position too: a few single positions at most.
        EXPECT_LE(found, passed) << text << " " << name_of(fault) << " " << place;
        EXPECT_GE(found, passed - std::ldexp(1.0L, 1 - int{format.channel_list[0].position.bits}))
            << text << " " << name_of(fault) << " " << place;
      };
      expect(FaultKind::lost_start, slip_conditions(format, lost_start(place)));
      expect(FaultKind::false_start, slip_conditions(format, false_start(place)));
    }
  }
}

// error-detection, section 4.
TEST(Structure, FactSheet_IsTheListed) {
  const auto row = [](const char* text, FaultKind fault) {
    return structure_row(format_of(text), fault, {});
  };
  const auto lost = row("pos32,nE,nW,crc6;cds0", FaultKind::lost_bit);
  // Except a single position that is read right.
  EXPECT_EQ(lost.worst.first_word, 0.125L - std::ldexp(1.0L, -32));
  EXPECT_NEAR(static_cast<double>(lost.sum.first_word / lost.places), 0.01, 0.006);
  const auto late = row("pos18,nE,nW,crc6;cds0", FaultKind::lost_start);
  EXPECT_EQ(late.sum.first_word, 0.125L);
  EXPECT_EQ(late.worst_place, 3U);
  EXPECT_EQ(late.sum.trusted, 0.0625L);
  for (const char* const text :
       {"pos18,nE,nW,crc6", "pos26,nE,nW,crc6", "pos32,nE,nW,crc6", "pos36,nE,nW,crc6"}) {
    EXPECT_EQ(passed_shares(format_of(text), FaultKind::lost_start, 1, {}).first_word, 0);
    EXPECT_EQ(passed_shares(format_of(text), FaultKind::false_start, 1, {}).first_word, 0);
    EXPECT_EQ(row(text, FaultKind::slo_high).sum.first_word, 0);
  }
}

constexpr FrameFormat renishaw18 = *parse_format("pos18,nE,nW,crc6;cds0");

constexpr std::optional<unsigned> none;

// Enumerates all values of a channel's position and counts those that pass with `slip`.
struct SlipCount {
  std::uint64_t accepted = 0;
  std::uint64_t trusted = 0;
};

// The frame on the line with its slip: what decode_payload() sees from the wrong START on.
SlipCount enumerate(const FrameFormat& format, unsigned bits, int place, unsigned ack_clocks,
                    bool cds) {
  const FrameCodec<CrcBitwise, 1> codec(format);
  SlipCount count;
  for (std::uint64_t position = 0; position < (std::uint64_t{1} << bits); ++position) {
    Frame frame;
    frame.channel_count = 1;
    frame.cds = cds;
    frame.lead_clocks = 4;
    frame.ack_clocks = static_cast<std::uint16_t>(ack_clocks);
    frame.channel_list[0].position = position;
    FrameBits line = *encode_frame(frame, codec);
    line.append_run(false, 40);
    const std::size_t start = 4 + ack_clocks;
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

std::uint64_t words(std::optional<unsigned> conditions, unsigned bits) {
  return conditions ? (std::uint64_t{1} << bits) >> *conditions : 0;
}

void compare(std::string_view text, unsigned bits, bool cds) {
  const FrameFormat format = *parse_format(text);
  const unsigned ack_clocks = 6;
  for (int place = -8; place <= static_cast<int>(format.payload_bits()) + 4; ++place) {
    if (place == 0) continue;
    const SlipCount count = enumerate(format, bits, place, ack_clocks, cds);
    const Slip slip{.place = place, .ack_clocks = ack_clocks};
    const SlipModel model{.cds = cds};
    const SlipModel trusted{.cds = cds, .trusted_only = true};
    EXPECT_EQ(words(slip_conditions(format, slip, model), bits), count.accepted) << " at " << place;
    EXPECT_EQ(words(slip_conditions(format, slip, trusted), bits), count.trusted)
        << " at " << place;
  }
}

TEST(Slip, AllPositionsOfSmallFormats_AgreeWithTheCount) {
  const unsigned bits = static_cast<unsigned>(10);
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
    EXPECT_TRUE(slip_conditions(flags, slip, {.healthy_flags = false}) ==
                slip_conditions(data, slip));
  }
}

TEST(Slip, TailChecked_LeavesFewerEarlyStarts) {
  // After a START in ACK, bits of the frame follow the STOP that is seen.
  EXPECT_TRUE(slip_conditions(renishaw18, false_start(12)) == 7U);
  EXPECT_TRUE(slip_conditions(renishaw18, false_start(12), {.tail_checked = true}) == none);
  EXPECT_TRUE(slip_conditions(renishaw18, false_start(3), {.tail_checked = true}) == 3U);
  // After a late START only zeros follow.
  EXPECT_TRUE(slip_conditions(renishaw18, lost_start(3), {.tail_checked = true}) == 3U);
}

TEST(Slip, TrustedOnly_AsksForNoError) {
  EXPECT_TRUE(slip_conditions(renishaw18, lost_start(3), {.trusted_only = true}) == 4U);
}

TEST(Slip, OnesAfterALostAck_AreRequired) {
  // CDS 0 cannot extend the leading ones; CDS 1 must.
  const FrameFormat format = *parse_format("pos8,crc3");
  unsigned possible = 0;
  for (int place = 3; place < 12; ++place) {
    const Slip one{.place = place, .ones_clocks = 1};
    EXPECT_TRUE(slip_conditions(format, one) == none);
    EXPECT_TRUE(slip_conditions(format, {.place = place}, {.cds = true}) == none);
    if (slip_conditions(format, one, {.cds = true})) ++possible;
  }
  EXPECT_TRUE(possible != 0);
}

TEST(Slip, TwoChannels_NeedBothChecksums) {
  const FrameFormat one = *parse_format("pos12,nE,nW,crc6");
  const FrameFormat two = *parse_format("pos12,nE,nW,crc6+pos12,nE,nW,lc6,crc16");
  for (unsigned distance = 1; distance < 30; ++distance) {
    const auto single = slip_conditions(one, lost_start(distance));
    const auto both = slip_conditions(two, lost_start(distance));
    EXPECT_TRUE(!both || !single || *both > *single) << " at " << distance;
    EXPECT_TRUE(both == slip_conditions(two, lost_start(distance))) << " at " << distance;
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
    EXPECT_TRUE(slip_conditions(apart, slip, aligned) == slip_conditions(apart, slip));
    EXPECT_TRUE(slip_conditions(apart, slip) == slip_conditions(format, slip));
    if (slip_conditions(format, slip, aligned) != slip_conditions(format, slip)) ++different;
  }
  EXPECT_TRUE(different != 0);
}

TEST(Slip, RenishawsWidths_PassAsTheFactSheetSays) {
  // START lost at 18 bits: a position passes if and only if it begins with 010.
  EXPECT_EQ(slip_conditions(renishaw18, lost_start(3)), 3U);
  // One bit early or late passes nowhere at Renishaw's widths because the CRC is inverted …
  EXPECT_EQ(slip_conditions(renishaw18, false_start(1)), none);
  EXPECT_EQ(slip_conditions(*parse_format("pos18,nE,nW,crc6"), false_start(1)), none);
  EXPECT_EQ(slip_conditions(*parse_format("pos36,nE,nW,crc6"), lost_start(1), {.cds = true}), none);
  // … and would for half of all words if it were not.
  EXPECT_EQ(slip_conditions(*parse_format("pos18,nE,nW,crc6:plain"), false_start(1)), 1U);
}

}  // namespace structure_test
}  // namespace biss::lab
