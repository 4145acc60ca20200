// Input that no encoder sends: the decoder accepts any bits and the parser any text. Buffers have
// exactly their size, so that a sanitizer detects an access outside.
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "tests/core/test.hpp"
#include "tests/exhaustive/scale.hpp"
#include "tests/exhaustive/twin.hpp"

namespace exhaustive {
namespace hostile_test {

// Runs of equal bits, as lines have, and noise.
std::vector<std::uint8_t> random_bytes(biss::test::Random& random) {
  oracle::Bits bits;
  const std::size_t size = 8 * static_cast<std::size_t>(random.below(40));
  bool level = true;
  while (bits.size() < size) {
    const std::uint32_t run = random.flip() ? 1 + random.below(3) : 1 + random.below(60);
    bits.insert(bits.end(), run, level);
    level = !level;
  }
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < size; i += 8) {
    bytes.push_back(static_cast<std::uint8_t>(oracle::number_of(bits, i, 8)));
  }
  return bytes;
}

TEST(HostileBits, OfAnySizeAndOffset_AreReadAlike) {
  BISS_RANDOM(random, 0x4057'0001);
  std::uint64_t frames = 0;
  for (std::uint64_t round = 0; round < rounds(100'000); ++round) {
    oracle::Description description;
    for (std::uint32_t left = 1 + random.below(8); left > 0; --left) {
      description.channels.push_back(random_channel(random));
    }
    const Twin twin = twin_of(description);
    const biss::FrameCodec<biss::CrcBitwise> codec(twin.format);
    const std::vector<std::uint8_t> bytes = random_bytes(random);
    const biss::BitView view(bytes, random.below(17), random.below(330));
    const auto frame = biss::decode_frame(view, codec);
    if (frame.ok()) ++frames;
    const oracle::Reading judge = oracle::decode(description, {}, bits_of(view));
    ASSERT_EQ(difference(frame, judge), "") << twin.text << " round " << round;
  }
  EXPECT_GT(frames, 0U);
}

// The parser's verdict on a text: a mistake inside it, or a format that its canonical text keeps.
std::string complaint(const std::string& text) {
  const std::vector<char> exact(text.begin(), text.end());
  const auto format = biss::parse_format(std::string_view(exact.data(), exact.size()));
  if (!format.ok()) {
    if (biss::text_of(format.error().mistake).empty()) return "a mistake without words";
    return format.error().at <= text.size() ? "" : "points outside";
  }
  const biss::FormatText canonical = biss::format_text(*format);
  const auto again = biss::parse_format(canonical.view());
  if (!again.ok()) return "the canonical text does not read";
  if (*again != *format) return "the canonical text reads differently";
  return biss::format_text(*again).view() == canonical.view() ? "" : "not canonical";
}

TEST(HostileText, OfTheGrammarsLetters_ReadsOrPointsInside) {
  BISS_RANDOM(random, 0x4057'0002);
  constexpr std::string_view letters = "posmtadlcrnEW:,+;xgyi0123456789ABCF";
  for (std::uint64_t round = 0; round < rounds(500'000); ++round) {
    std::string text;
    for (std::uint32_t left = random.below(24); left > 0; --left) {
      text += letters[random.below(letters.size())];
    }
    ASSERT_EQ(complaint(text), "") << "'" << text << "'";
  }
}

TEST(HostileText, OfTheGrammarsWords_ReadsOrPointsInside) {
  BISS_RANDOM(random, 0x4057'0003);
  constexpr std::array<std::string_view, 30> words{
      "pos",   "mt",     "st",  "pad",  "nE",    "nW", "E",  "W",  "lc", "crc",
      ":gray", ":plain", ":0x", "cds0", ";cds0", ",",  ",",  ",",  "+",  ";",
      "1",     "2",      "3",   "6",    "8",     "12", "16", "43", ":",  "0x43"};
  std::uint64_t read = 0;
  for (std::uint64_t round = 0; round < rounds(500'000); ++round) {
    std::string text;
    for (std::uint32_t left = random.below(12); left > 0; --left) {
      text += words[random.below(words.size())];
    }
    ASSERT_EQ(complaint(text), "") << "'" << text << "'";
    if (biss::parse_format(text).ok()) ++read;
  }
  EXPECT_GT(read, rounds(500'000) / 500);
}

// A good text with one character changed, left out or doubled.
TEST(HostileText, NextToAFormat_ReadsOrPointsInside) {
  BISS_RANDOM(random, 0x4057'0004);
  for (std::uint64_t round = 0; round < rounds(100'000); ++round) {
    std::string text = twin_of({{random_channel(random), random_channel(random)}, true}).text;
    const std::size_t at = random.below(static_cast<std::uint32_t>(text.size()));
    const std::uint32_t change = random.below(3);
    if (change == 0) text.erase(at, 1);
    if (change == 1) text.insert(at, 1, text[at]);
    if (change == 2) text[at] = static_cast<char>(random.bits(8));
    ASSERT_EQ(complaint(text), "") << "'" << text << "'";
  }
}

}  // namespace hostile_test

}  // namespace exhaustive
