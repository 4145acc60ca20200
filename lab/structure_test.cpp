#include "lab/structure.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>
#include <cstdint>
#include <string_view>
#include <vector>

#include "biss/crc/engines.hpp"
#include "biss/frame/format_text.hpp"
#include "lab/comparison.hpp"
#include "lab/slip.hpp"

namespace biss::lab {
namespace {

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

// Damages the line; where START is seen then.
std::size_t damage(Levels& line, StructuralFault fault, unsigned place, unsigned gap_bits) {
  const auto at = line.begin() + static_cast<std::ptrdiff_t>(ack + place);
  switch (fault) {
    case StructuralFault::lost_bit:
      line.erase(at);
      break;
    case StructuralFault::doubled_bit:
      line.insert(at, bool{*at});
      break;
    case StructuralFault::inserted_low:
    case StructuralFault::inserted_high:
      line.insert(at, fault == StructuralFault::inserted_high);
      break;
    case StructuralFault::stuck_low:
    case StructuralFault::stuck_high:
      std::fill(at, line.end(), fault == StructuralFault::stuck_high);
      break;
    case StructuralFault::gap_low:
    case StructuralFault::gap_high:
      std::fill(at, at + gap_bits, fault == StructuralFault::gap_high);
      break;
    case StructuralFault::late_start:
      line[ack] = false;
      break;
    case StructuralFault::early_start:
      line[ack - place] = true;
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
  const unsigned bits = model.checks.compare_bits == 0 ? both : model.checks.compare_bits;
  const std::uint64_t range = std::uint64_t{1} << bits;
  const std::uint64_t a = position >> (channels[0].position.bits - bits);
  const std::uint64_t b = channels[1].position.of(words[1]) >> (both - bits);
  const std::uint64_t up = (a + range - b) % range;
  const unsigned tolerance = model.checks.tolerance_lsb;
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
  for (const StructuralFault fault : structural_faults) {
    StructureRow row;
    for (unsigned place = 1; place < format.payload_bits() + 2; ++place) {
      PassedShares counted;
      for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(all); ++i) {
        const Truth truth{i >> counter_bits, i & low_mask(counter_bits)};
        Levels line = line_of(format, truth, model.pair);
        const std::size_t start = damage(line, fault, place, model.gap_bits);
        if (fault == StructuralFault::late_start && start != ack + place) continue;
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
                        {.pair = true, .checks = {.compare_bits = 3}, .gap_bits = 5});
  any += expect_counted("pos6,nE,nW,crc3:plain+pos6,nE,lc2,crc3:plain",
                        {.pair = true, .checks = {.tolerance_lsb = 0}, .gap_bits = 3});
  EXPECT_GT(any, 0);
}

TEST(Structure, LateAndEarlyStart_AreSlipsHalvings) {
  for (const char* const text : {"pos18,nE,nW,crc6;cds0", "pos26,nE,nW,crc6;cds0",
                                 "pos32,nE,nW,crc6;cds0", "pos36,nE,nW,crc6;cds0"}) {
    const FrameFormat format = format_of(text);
    for (unsigned place = 1; place < format.payload_bits(); ++place) {
      const auto expect = [&](StructuralFault fault, std::optional<unsigned> halvings) {
        const long double passed = halvings ? std::ldexp(1.0L, -static_cast<int>(*halvings)) : 0;
        const long double found = passed_shares(format, fault, place, {}).all_words;
        // Slips count what passes with the right position too: a few single positions at most.
        EXPECT_LE(found, passed) << text << " " << name_of(fault) << " " << place;
        EXPECT_GE(found, passed - std::ldexp(1.0L, 1 - int{format.channel_list[0].position.bits}))
            << text << " " << name_of(fault) << " " << place;
      };
      expect(StructuralFault::late_start, lost_start_halvings<1>(format, place));
      expect(StructuralFault::early_start, early_start_halvings<1>(format, place));
    }
  }
}

// error-detection, section 4.
TEST(Structure, FactSheet_IsTheListed) {
  const auto row = [](const char* text, StructuralFault fault) {
    return structure_row(format_of(text), fault, {});
  };
  const auto lost = row("pos32,nE,nW,crc6;cds0", StructuralFault::lost_bit);
  // But for a single position that comes out right.
  EXPECT_EQ(lost.worst.first_word, 0.125L - std::ldexp(1.0L, -32));
  EXPECT_NEAR(static_cast<double>(lost.sum.first_word / lost.places), 0.01, 0.006);
  const auto late = row("pos18,nE,nW,crc6;cds0", StructuralFault::late_start);
  EXPECT_EQ(late.sum.first_word, 0.125L);
  EXPECT_EQ(late.worst_place, 3U);
  EXPECT_EQ(late.sum.trusted, 0.0625L);
  for (const char* const text :
       {"pos18,nE,nW,crc6", "pos26,nE,nW,crc6", "pos32,nE,nW,crc6", "pos36,nE,nW,crc6"}) {
    EXPECT_EQ(passed_shares(format_of(text), StructuralFault::late_start, 1, {}).first_word, 0);
    EXPECT_EQ(passed_shares(format_of(text), StructuralFault::early_start, 1, {}).first_word, 0);
    EXPECT_EQ(row(text, StructuralFault::stuck_high).sum.first_word, 0);
  }
}

}  // namespace
}  // namespace biss::lab
