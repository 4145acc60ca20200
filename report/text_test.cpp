#include "report/text.hpp"

#include <gtest/gtest.h>

#include <array>
#include <clocale>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <locale>
#include <random>
#include <string>
#include <vector>

#include "tests/common/german_punctuation.hpp"
#include "tests/common/random.hpp"

namespace biss::report {
namespace text_test {

std::string nanoseconds_text(std::int64_t picosecond_count) {
  std::array<char, number_chars> text;
  return {text.data(), put_nanoseconds(text.data(), picoseconds(picosecond_count))};
}

std::string fixed(std::int64_t value, unsigned shift, unsigned places) {
  std::string out;
  append_fixed(out, magnitude_of(value), shift, places);
  return out;
}

std::string hex(BitView bits) {
  std::string out(hex_chars(bits), ' ');
  out.resize(static_cast<std::size_t>(put_hex(out.data(), bits) - out.data()));
  return out;
}

std::string printable(std::string_view text) {
  std::string out;
  append_printable(out, text);
  return out;
}

// Changes the C++ locale always, the C locale if a German one is installed.
class GermanLocale {
 public:
  GermanLocale() : before_(std::locale::global(std::locale({}, new test::GermanPunctuation))) {
    for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "de_DE"}) {
      if (std::setlocale(LC_ALL, name) != nullptr) break;
    }
  }
  ~GermanLocale() {
    std::locale::global(before_);
    std::setlocale(LC_ALL, "C");
  }

 private:
  std::locale before_;
};

TEST(Nanoseconds, WholeAndFraction_AreExactWithoutTrailingZeros) {
  EXPECT_EQ(nanoseconds_text(0), "0");
  EXPECT_EQ(nanoseconds_text(1), "0.001");
  EXPECT_EQ(nanoseconds_text(112'500), "112.5");
  EXPECT_EQ(nanoseconds_text(112'050), "112.05");
  EXPECT_EQ(nanoseconds_text(100'000), "100");
  EXPECT_EQ(nanoseconds_text(-1), "-0.001");
  EXPECT_EQ(nanoseconds_text(-1'500), "-1.5");
}

TEST(Nanoseconds, EndsOfTheRange_AreExact) {
  EXPECT_EQ(nanoseconds_text(std::numeric_limits<std::int64_t>::max()), "9223372036854775.807");
  EXPECT_EQ(nanoseconds_text(std::numeric_limits<std::int64_t>::min()), "-9223372036854775.808");
}

TEST(Nanoseconds, RandomTimes_ReadBackAsTheSamePicoseconds) {
  std::mt19937_64 random = test::random_of();
  for (int i = 0; i < 20'000; ++i) {
    const auto count = static_cast<std::int64_t>(random()) >> (random() % 64);
    std::string text = nanoseconds_text(count);
    const auto point = text.find('.');
    std::size_t places = 0;
    if (point != std::string::npos) {
      places = text.size() - point - 1;
      ASSERT_NE(text.back(), '0') << text;
      text.erase(point, 1);
    }
    text.append(3 - places, '0');
    ASSERT_EQ(std::stoll(text), count);
  }
}

TEST(Fixed, Rounding_IsHalfAwayFromZero) {
  EXPECT_EQ(fixed(1'499, 3, 0), "1");
  EXPECT_EQ(fixed(1'500, 3, 0), "2");
  EXPECT_EQ(fixed(-1'500, 3, 0), "-2");
  EXPECT_EQ(fixed(9'999'500, 6, 3), "10.000");
  EXPECT_EQ(fixed(9'999'499, 6, 3), "9.999");
}

TEST(Fixed, WhatRoundsToZero_HasNoSign) {
  EXPECT_EQ(fixed(-40, 3, 1), "0.0");
  EXPECT_EQ(fixed(-50, 3, 1), "-0.1");
}

TEST(Fixed, MorePlacesThanDigits_AreFilledWithZeros) {
  EXPECT_EQ(fixed(5, 0, 2), "5.00");
  EXPECT_EQ(fixed(5, 1, 3), "0.500");
  EXPECT_EQ(fixed(1, 18, 18), "0.000000000000000001");
}

TEST(Fixed, LargestNumbers_DoNotOverflow) {
  std::string out;
  append_fixed(out, {std::numeric_limits<std::uint64_t>::max(), false}, 0, 0);
  EXPECT_EQ(out, "18446744073709551615");
  out.clear();
  append_fixed(out, {std::numeric_limits<std::uint64_t>::max(), false}, 18, 0);
  EXPECT_EQ(out, "18");
  EXPECT_EQ(fixed(std::numeric_limits<std::int64_t>::min(), 0, 0), "-9223372036854775808");
}

TEST(Hex, AnyBitCount_IsOneNumberWithZerosInFront) {
  const std::vector<std::uint8_t> bytes = {0xA5, 0x3C, 0xFF};
  EXPECT_EQ(hex(BitView(bytes, 0, 0)), "");
  EXPECT_EQ(hex(BitView(bytes, 0, 1)), "0x1");
  EXPECT_EQ(hex(BitView(bytes, 0, 8)), "0xA5");
  EXPECT_EQ(hex(BitView(bytes, 0, 9)), "0x14A");
  EXPECT_EQ(hex(BitView(bytes, 1, 7)), "0x25");
  EXPECT_EQ(hex(BitView(bytes, 0, 24)), "0xA53CFF");
}

TEST(Numbers, GermanLocale_ChangesNothing) {
  const GermanLocale german;
  char probe[32];
  std::snprintf(probe, sizeof probe, "%.1f", 1.5);
  std::printf("C locale writes 1.5 as %s\n", probe);
  std::string out;
  append_number(out, std::uint64_t{1'234'567});
  append_number(out, std::int64_t{-1'234'567});
  EXPECT_EQ(out, "1234567-1234567");
  EXPECT_EQ(nanoseconds_text(1'234'567'890), "1234567.89");
  EXPECT_EQ(fixed(1'234'567'890, 3, 2), "1234567.89");
}

TEST(CodePoints, ValidSequences_AreDecoded) {
  EXPECT_EQ(front_code_point("A").value, U'A');
  EXPECT_EQ(front_code_point("µ").value, U'µ');
  EXPECT_EQ(front_code_point("€").value, U'€');
  EXPECT_EQ(front_code_point("😀").value, U'😀');
  EXPECT_EQ(front_code_point("😀").bytes, 4U);
}

TEST(CodePoints, InvalidSequences_AreSteppedOverByOneByte) {
  for (const std::string_view text :
       {"\x80", "\xC3", "\xC0\x80", "\xC1\xBF", "\xE0\x80\x80", "\xED\xA0\x80", "\xE2\x82",
        "\xF0\x80\x80\x80", "\xF4\x90\x80\x80", "\xF5\x80\x80\x80", "\xFF", "\xC3(", "\xE2\x82(",
        "\xF0\x9F\x98"}) {
    const CodePoint point = front_code_point(text);
    EXPECT_FALSE(point.valid) << printable(text);
    EXPECT_EQ(point.bytes, 1U);
  }
}

TEST(Printable, ControlAndInvalidBytes_BecomeReplacementCharacters) {
  EXPECT_EQ(printable("a\x1b[2Jb"), "a\uFFFD[2Jb");
  EXPECT_EQ(printable("a\nb\tc\x7f"), "a\uFFFDb\uFFFDc\uFFFD");
  EXPECT_EQ(printable("\xC2\x9B"), "\uFFFD");  // a C1 control: another way to write an escape
  EXPECT_EQ(printable("\xff\xfeok"), "\uFFFD\uFFFDok");
  EXPECT_EQ(printable("\u202Eabc"), "\uFFFDabc");
  EXPECT_EQ(printable("Länge 5 µm"), "Länge 5 µm");
  EXPECT_EQ(printable(std::string_view("\0", 1)), "\uFFFD");
}

TEST(Width, NonAscii_CountsColumnsNotBytes) {
  EXPECT_EQ(display_width(""), 0U);
  EXPECT_EQ(display_width("µs"), 2U);
  EXPECT_EQ(display_width("編碼器"), 6U);
  EXPECT_EQ(display_width("a\u0308"), 1U);  // a with a combining diaeresis
  EXPECT_EQ(display_width("😀"), 2U);
  EXPECT_EQ(display_width("\uFFFD"), 1U);
}

TEST(Padding, NarrowText_IsFilledAndWideTextIsKept) {
  std::string out;
  append_padded(out, "µs", 4, true);
  append_padded(out, "編", 4, false);
  append_padded(out, "wider", 2, true);
  EXPECT_EQ(out, "  µs編  wider");
}

}  // namespace text_test
}  // namespace biss::report
