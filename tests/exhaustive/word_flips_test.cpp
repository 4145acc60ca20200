// All flips inside the word up to a weight: each gives a cause, or exactly as many are accepted as
// the weight distribution of the code gives. Also lines that end too early.
#include <gtest/gtest.h>

#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive::word_flips_test {

using Codec = biss::FrameCodec<biss::CrcFast, 1>;

struct Word {
  const char* format;
  unsigned position_bits;
  unsigned word_bits;
  /// Accepted patterns of exactly 0, 1, 2 … flips.
  std::array<std::uint64_t, 7> accepted;
};

// CPW to four flips, SPW to six; the counts are those of the exact weight distributions.
constexpr std::array cpw{
    Word{"pos18,nE,nW,crc6;cds0", 18, 26, {1, 0, 0, 40, 240, 0, 0}},
    Word{"pos26,nE,nW,crc6;cds0", 26, 34, {1, 0, 0, 98, 753, 0, 0}},
    Word{"pos28,nE,nW,crc6;cds0", 28, 36, {1, 0, 0, 119, 958, 0, 0}},
    Word{"pos32,nE,nW,crc6;cds0", 32, 40, {1, 0, 0, 163, 1495, 0, 0}},
    Word{"pos36,nE,nW,crc6;cds0", 36, 44, {1, 0, 0, 213, 2230, 0, 0}},
};
constexpr std::array spw{
    Word{"pos24,nE,nW,lc6,crc16;cds0", 24, 48, {1, 0, 0, 0, 0, 0, 369}},
    Word{"pos28,nE,nW,lc6,crc16;cds0", 28, 52, {1, 0, 0, 0, 0, 0, 602}},
    Word{"pos32,nE,nW,lc6,crc16;cds0", 32, 56, {1, 0, 0, 0, 0, 0, 946}},
};

constexpr std::size_t lead = 2;
constexpr std::size_t ack = 33;
constexpr std::size_t first_bit = lead + ack + 2;

class Flipper {
 public:
  Flipper(const Word& word, std::uint64_t position)
      : codec_(*biss::parse_format(word.format)), bits_(encoded(position)) {}

  /// All patterns of `flips` flips among the first `below` bits of the word.
  std::uint64_t accepted(unsigned flips, std::size_t below) {
    if (flips == 0) return passes() ? 1 : 0;
    std::uint64_t sum = 0;
    for (std::size_t i = flips - 1; i < below; ++i) {
      bits_.flip(first_bit + i);
      sum += accepted(flips - 1, i);
      bits_.flip(first_bit + i);
    }
    return sum;
  }

  /// All bursts of this length within the word.
  std::uint64_t accepted_bursts(unsigned bits, unsigned word_bits) {
    std::uint64_t sum = 0;
    const std::uint64_t patterns = std::uint64_t{1} << (bits < 3 ? 0 : bits - 2);
    for (unsigned place = 0; place + bits <= word_bits; ++place) {
      for (std::uint64_t inside = 0; inside < patterns; ++inside) {
        const std::uint64_t pattern = 1U | (inside << 1U) | (std::uint64_t{1} << (bits - 1U));
        flip(place, pattern);
        if (passes()) ++sum;
        flip(place, pattern);
      }
    }
    return sum;
  }

  std::uint64_t other_causes() const { return other_causes_; }

 private:
  biss::FrameBits encoded(std::uint64_t position) const {
    biss::Frame sent;
    sent.channel_count = 1;
    sent.channel_list[0].position = position;
    sent.lead_clocks = lead;
    sent.ack_clocks = ack;
    return *biss::encode_frame(sent, codec_);
  }

  void flip(unsigned place, std::uint64_t pattern) {
    for (; pattern != 0; pattern >>= 1U, ++place) {
      if ((pattern & 1U) != 0) bits_.flip(first_bit + place);
    }
  }

  bool passes() {
    const auto frame = biss::decode_frame(bits_.view(), codec_);
    if (frame.ok()) return true;
    if (frame.error() != biss::FrameFault{biss::FrameError::crc, 0}) ++other_causes_;
    return false;
  }

  Codec codec_;
  biss::FrameBits bits_;
  std::uint64_t other_causes_ = 0;
};

void expect_counts(const Word& word, std::uint64_t position, unsigned most_flips) {
  Flipper flipper(word, position);
  for (unsigned flips = 0; flips <= most_flips; ++flips) {
    EXPECT_EQ(flipper.accepted(flips, word.word_bits), word.accepted[flips])
        << word.format << ", " << flips << " flips, position " << position;
  }
  EXPECT_EQ(flipper.other_causes(), 0U) << word.format;
}

TEST(WordFlips, OfACpw_PassAsOftenAsTheCodeSays) {
  BISS_RANDOM(random, 0xF11D'0001);
  for (const Word& word : cpw) {
    expect_counts(word, 0, slow_build ? 3 : 4);
    expect_counts(word, biss::low_mask(word.position_bits), 3);
    expect_counts(word, random.bits(word.position_bits), slow_build ? 3 : 4);
  }
}

TEST(WordFlips, OfAnSpwUpToFive_NeverPass) {
  BISS_RANDOM(random, 0xF11D'0002);
  for (const Word& word : spw) {
    expect_counts(word, random.bits(word.position_bits), slow_build ? 3 : 5);
  }
}

TEST(WordFlips, SixInAnSpw_PassAsOftenAsTheCodeSays) {
  if (slow_build) GTEST_SKIP() << "65 million frames are too many for an instrumented build";
  BISS_RANDOM(random, 0xF11D'0003);
  for (const Word& word : spw) {
    Flipper flipper(word, random.bits(word.position_bits));
    EXPECT_EQ(flipper.accepted(6, word.word_bits), word.accepted[6]) << word.format;
  }
}

// First and last bit wrong, any bits between them, at any place in the word.
TEST(WordBursts, UpToTheWidthOfTheChecksum_NeverPass) {
  BISS_RANDOM(random, 0xF11D'0005);
  const auto passing = [&](const Word& word, unsigned longest_bits) {
    Flipper flipper(word, random.bits(word.position_bits));
    std::uint64_t passed = 0;
    for (unsigned bits = 1; bits <= longest_bits; ++bits) {
      passed += flipper.accepted_bursts(bits, word.word_bits);
    }
    EXPECT_EQ(flipper.other_causes(), 0U) << word.format;
    return passed;
  };
  for (const Word& word : cpw) EXPECT_EQ(passing(word, 6), 0U) << word.format;
  for (const Word& word : spw) EXPECT_EQ(passing(word, slow_build ? 10 : 16), 0U) << word.format;
  // One bit longer: the checksum's own polynomial, at any place.
  EXPECT_EQ(passing(cpw[4], 7), cpw[4].word_bits - 6U);
  if (slow_build) return;
  EXPECT_EQ(passing(spw[2], 17), spw[2].word_bits - 16U);
}

TEST(Prefixes, OfEveryWord_HaveTheirCauseForBothReaders) {
  BISS_RANDOM(random, 0xF11D'0004);
  using oracle::Kind;
  for (const unsigned width : {18U, 26U, 28U, 32U, 36U}) {
    const Twin twin = twin_of(
        {{{{{Kind::position, width}, {Kind::nE, 1}, {Kind::nW, 1}}, checksum_of(6, true, 0)}},
         true});
    const Codec codec(twin.format);
    for (std::uint64_t round = 0; round < rounds(200); ++round) {
      const Sent sent = random_sent(twin.description, random);
      const oracle::Bits whole =
          oracle::encode(twin.description, sent.values, sent.lead, sent.ack, sent.cds);
      for (std::size_t size = 0; size < whole.size(); ++size) {
        const oracle::Bits line(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
        ASSERT_EQ(judge_line(twin, codec, line), "") << "size " << size;
        const bool all_but_stop = size + 1 == whole.size();
        ASSERT_EQ(biss::decode_frame(line_of(line).view(), codec).ok(), all_but_stop)
            << "size " << size;
      }
    }
  }
}

}  // namespace exhaustive::word_flips_test
