#include "capture/decimal.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <optional>
#include <random>
#include <string>

#include "tests/common/random.hpp"

namespace biss::capture {
namespace decimal_test {

constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();

std::optional<std::int64_t> value_of(std::string_view text, int scale = 3, bool comma = false) {
  const auto parsed = parse_decimal(text, scale, comma);
  return parsed.ok() ? std::optional(*parsed) : std::nullopt;
}

TEST(Decimal, PlainNumbers_AreScaledExactly) {
  EXPECT_EQ(value_of("0"), 0);
  EXPECT_EQ(value_of("42007.500"), 42'007'500);
  EXPECT_EQ(value_of("42007.5"), 42'007'500);
  EXPECT_EQ(value_of("+7."), 7'000);
  EXPECT_EQ(value_of(".5"), 500);
  EXPECT_EQ(value_of("-0.001"), -1);
  EXPECT_EQ(value_of("0.1", 12), 100'000'000'000);
  EXPECT_EQ(value_of("0.000042007500", 12), 42'007'500);
}

TEST(Decimal, HalvesOfAUnit_RoundAwayFromZero) {
  EXPECT_EQ(value_of("0.0004999999999999999999999999"), 0);
  EXPECT_EQ(value_of("0.0005"), 1);
  EXPECT_EQ(value_of("-0.0005"), -1);
  EXPECT_EQ(value_of("1.0015"), 1'002);
  EXPECT_EQ(value_of("-1.00149999"), -1'001);
  EXPECT_EQ(value_of("5e-1", 0), 1);
  EXPECT_EQ(value_of("5e-2", 0), 0);
}

TEST(Decimal, Exponents_MoveThePoint) {
  EXPECT_EQ(value_of("4.2E-5", 12), 42'000'000);
  EXPECT_EQ(value_of("1.5e+2"), 150'000);
  EXPECT_EQ(value_of("12345e-4"), 1'235);
  EXPECT_EQ(value_of("1e-400"), 0);
  EXPECT_EQ(value_of("0e99999999999999999999"), 0);
}

TEST(Decimal, MoreDigitsThanFit_AreStillExact) {
  EXPECT_EQ(value_of("9223372036854775.807"), largest);
  EXPECT_EQ(value_of("-9223372036854775.807"), -largest);
  EXPECT_EQ(value_of("0000000000000000000000000000000001.000000000000000000000000"), 1'000);
  EXPECT_EQ(value_of("1234567890123456789", 0), 1'234'567'890'123'456'789);
}

TEST(Decimal, BeyondTheRange_ReportsOutOfRange) {
  for (const char* text : {"9223372036854775.808", "9223372036854775.8075", "1e30", "-1e30",
                           "99999999999999999999", "1e99999999999999999999"}) {
    const auto parsed = parse_decimal(text, 3);
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_EQ(parsed.error(), DecimalCause::out_of_range) << text;
  }
}

TEST(Decimal, NoNumber_IsSaid) {
  for (const char* text : {"", ".", "-", "+", "1e", "1e+", "e5", "1.2.3", "1,5", "nan", "inf",
                           "0x10", "1 2", " 1", "--1", "1-"}) {
    const auto parsed = parse_decimal(text, 3);
    ASSERT_FALSE(parsed.ok()) << text;
    EXPECT_EQ(parsed.error(), DecimalCause::no_number) << text;
  }
}

TEST(Decimal, DecimalComma_OnlyWhereAllowed) {
  EXPECT_EQ(value_of("1,5", 3, true), 1'500);
  EXPECT_EQ(value_of("1.5", 3, true), 1'500);
  EXPECT_EQ(value_of("1,5", 3, false), std::nullopt);
}

TEST(Decimal, RandomPicoseconds_ComeBackFromEveryUnit) {
  std::mt19937_64 random = test::random_of(20'240'611);
  for (int i = 0; i < 20'000; ++i) {
    const auto value = static_cast<std::int64_t>(random() >> (1 + random() % 62));
    std::string digits = std::to_string(value);
    for (const int scale : {0, 3, 6, 9, 12}) {
      std::string text = digits;
      const auto places = static_cast<std::size_t>(scale);
      if (text.size() <= places) text.insert(0, places + 1 - text.size(), '0');
      text.insert(text.size() - places, ".");
      ASSERT_EQ(value_of(text, scale), value) << text << " scale " << scale;
      ASSERT_EQ(value_of("-" + text, scale), -value) << text;
      ASSERT_EQ(value_of(digits + "e-" + std::to_string(scale), scale), value) << digits;
    }
  }
}

TEST(Digits, EveryCountAndFollower_GivesValueAndEnd) {
  const std::string digits = "1234567890123456789";
  for (std::size_t count = 0; count <= digits.size(); ++count) {
    for (int follower = 0; follower < 256; ++follower) {
      if (follower >= '0' && follower <= '9') continue;
      std::string text = digits.substr(0, count) + static_cast<char>(follower);
      text.resize(count + 24, '7');
      const Digits read = read_digits(text.data());
      ASSERT_EQ(read.end - text.data(), static_cast<std::ptrdiff_t>(count)) << follower;
      ASSERT_EQ(read.value, count == 0 ? 0 : std::stoull(digits.substr(0, count)));
    }
  }
}

}  // namespace decimal_test
}  // namespace biss::capture
