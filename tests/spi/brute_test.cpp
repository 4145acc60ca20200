// Every position of small formats, read from every wrong START: the number of accepted words is the
// computed one. This test has its own reader, which shares no code with the codec.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "lab/test_slip.hpp"
#include "tests/spi/effort.hpp"
#include "tests/spi/line_model.hpp"

namespace biss::test::spi::brute_test {

std::uint64_t mask(unsigned bits) { return (std::uint64_t{1} << bits) - 1; }

/// pos…,nE,nW,crc… with a CRC that is sent inverted and starts at 0.
struct Word {
  unsigned position_bits;
  unsigned crc_bits;
  std::uint64_t polynomial;

  unsigned payload_bits() const { return position_bits + 2 + crc_bits; }
  std::string text() const {
    return "pos" + std::to_string(position_bits) + ",nE,nW,crc" + std::to_string(crc_bits);
  }
  /// START, CDS 0, position, flags 11, CRC.
  std::uint64_t line(std::uint64_t position) const {
    const std::uint64_t data = (position << 2U) | 3U;
    const std::uint64_t crc = checksum(data, position_bits + 2, polynomial, crc_bits);
    return (std::uint64_t{2} << payload_bits()) | (data << crc_bits) | crc;
  }
};

/// The number of accepted words: with CDS and nE checked or not, and with the tail checked.
struct Passed {
  std::uint64_t any = 0;
  std::uint64_t cds0 = 0;
  std::uint64_t trusted = 0;
  std::uint64_t tail = 0;

  /// `seen` holds START, CDS, payload; `after` what follows, STOP first of `after_bits` bits.
  void add(const Word& word, std::uint64_t seen, std::uint64_t after, unsigned after_bits) {
    const std::uint64_t payload = seen & mask(word.payload_bits());
    const std::uint64_t data = payload >> word.crc_bits;
    if (checksum(data, word.position_bits + 2, word.polynomial, word.crc_bits) !=
        (payload & mask(word.crc_bits))) {
      return;
    }
    if (after_bits > 0 && ((after >> (after_bits - 1)) & 1U) != 0) return;
    ++any;
    if (((seen >> word.payload_bits()) & 1U) == 0) ++cds0;
    if ((data & 2U) != 0) ++trusted;
    if (after == 0) ++tail;
  }
};

std::uint64_t words(const Word& word, std::optional<unsigned> conditions) {
  return conditions ? (std::uint64_t{1} << word.position_bits) >> *conditions : 0;
}

void expect_counted(const Word& word, const Passed& passed, int place) {
  const FrameFormat format = *parse_format(word.text());
  FrameFormat with_cds0 = format;
  with_cds0.cds0 = true;
  const lab::Slip slip{.place = place, .ack_clocks = 100};
  EXPECT_EQ(words(word, lab::slip_conditions(format, slip)), passed.any)
      << word.text() << ' ' << place;
  EXPECT_EQ(words(word, lab::slip_conditions(with_cds0, slip)), passed.cds0)
      << word.text() << ' ' << place;
  EXPECT_EQ(words(word, lab::slip_conditions(format, slip, {.trusted_only = true})), passed.trusted)
      << word.text() << ' ' << place;
  EXPECT_EQ(words(word, lab::slip_conditions(format, slip, {.tail_checked = true})), passed.tail)
      << word.text() << ' ' << place;
}

std::vector<Word> small_words() {
  if (slow_build) return {{12, 6, 0x43}, {12, 4, 0x13}, {12, 8, 0x12F}};
  return {{12, 6, 0x43}, {13, 6, 0x43}, {14, 5, 0x25}, {15, 3, 0x0B},  {16, 4, 0x13},
          {16, 6, 0x43}, {17, 7, 0x89}, {18, 6, 0x43}, {18, 8, 0x12F}, {14, 16, 0x190D9}};
}

TEST(SlipBrute, LostStart_PassesForAsManyPositionsAsCounted) {
  for (const Word& word : small_words()) {
    const unsigned bits = word.payload_bits() + 2;
    std::vector<Passed> passed(bits);
    for (std::uint64_t position = 0; position <= mask(word.position_bits); ++position) {
      const std::uint64_t lost = word.line(position) & mask(bits - 1);
      if (lost == 0) continue;
      unsigned place = 0;
      while (((lost >> (bits - 1 - place)) & 1U) == 0) ++place;
      passed[place].add(word, (lost << place) & mask(bits), 0, 0);
    }
    for (unsigned place = 1; place < bits; ++place) {
      expect_counted(word, passed[place], static_cast<int>(place));
    }
  }
}

TEST(SlipBrute, StartInAck_PassesForAsManyPositionsAsCounted) {
  for (const Word& word : small_words()) {
    const unsigned bits = word.payload_bits() + 2;
    std::vector<Passed> passed(bits + 1);
    for (std::uint64_t position = 0; position <= mask(word.position_bits); ++position) {
      const std::uint64_t line = word.line(position);
      for (unsigned early = 1; early <= bits; ++early) {
        const std::uint64_t seen = (line >> early) | (std::uint64_t{1} << (bits - 1));
        passed[early].add(word, seen, line & mask(early), early);
      }
    }
    for (unsigned early = 1; early <= bits; ++early) {
      expect_counted(word, passed[early], -static_cast<int>(early));
    }
  }
}

TEST(SlipFacts, StartLostAt18Bits_PassesIfThePositionBegins010) {
  const Word word{18, 6, 0x43};
  for (std::uint64_t position = 0; position < (std::uint64_t{1} << 18U); ++position) {
    const std::uint64_t lost = word.line(position) & mask(27);
    unsigned place = 0;
    while (((lost >> (27 - place)) & 1U) == 0) ++place;
    Passed passed;
    passed.add(word, (lost << place) & mask(28), 0, 0);
    ASSERT_EQ(passed.any, (position >> 15U) == 2 ? 1U : 0U) << position;
    ASSERT_EQ(passed.cds0, passed.any) << position;
  }
}

TEST(SlipFacts, FrameSlippedByOneBit_IsCaughtBecauseTheCrcIsInverted) {
  for (const unsigned width : {18U, 26U, 28U, 32U, 36U}) {
    const std::string text = "pos" + std::to_string(width) + ",nE,nW,crc6";
    const FrameFormat inverted = *parse_format(text);
    const FrameFormat plain = *parse_format(text + ":plain");
    EXPECT_EQ(lab::slip_conditions(inverted, lab::false_start(1)), std::nullopt) << width;
    EXPECT_EQ(lab::slip_conditions(inverted, lab::lost_start(1), {.cds = true}), std::nullopt)
        << width;
    // Half of the words end with the 0 that is read as STOP, or begin with a 0.
    EXPECT_EQ(lab::slip_conditions(plain, lab::false_start(1)), 1U) << width;
    EXPECT_EQ(lab::slip_conditions(plain, lab::lost_start(1), {.cds = true}), 1U) << width;
  }
}

}  // namespace biss::test::spi::brute_test
