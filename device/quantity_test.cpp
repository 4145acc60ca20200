#include "device/quantity.hpp"

#include <gtest/gtest.h>

#include <locale>
#include <random>
#include <string>

#include "tests/common/german_punctuation.hpp"
#include "tests/common/random.hpp"

namespace biss {
namespace quantity_test {

Hertz rate(std::string_view text) {
  const auto parsed = parse_rate(text);
  EXPECT_TRUE(parsed.ok()) << text;
  return parsed.ok() ? *parsed : Hertz{};
}

Picoseconds duration(std::string_view text) {
  const auto parsed = parse_duration(text);
  EXPECT_TRUE(parsed.ok()) << text;
  return parsed.ok() ? *parsed : picoseconds(-1);
}

std::int64_t length(std::string_view text) {
  const auto parsed = parse_length(text);
  EXPECT_TRUE(parsed.ok()) << text;
  return parsed.ok() ? parsed->count : -1;
}

template <class Parsed>
void expect_wrong(const Parsed& parsed, QuantityCause cause, std::size_t at) {
  ASSERT_FALSE(parsed.ok());
  EXPECT_EQ(parsed.error().cause, cause);
  EXPECT_EQ(parsed.error().at, at);
}

TEST(Rate, EveryUnit_IsExact) {
  EXPECT_EQ(rate("10MHz"), megahertz(10));
  EXPECT_EQ(rate("250kHz"), kilohertz(250));
  EXPECT_EQ(rate("1.5MHz"), kilohertz(1'500));
  EXPECT_EQ(rate("32 kHz"), kilohertz(32));
  EXPECT_EQ(rate("1Hz"), hertz(1));
  EXPECT_EQ(rate("4.294967295GHz"), hertz(4'294'967'295U));
  EXPECT_EQ(rate("0.000001MHz"), hertz(1));
  EXPECT_EQ(rate("1.500000000000MHz"), kilohertz(1'500));
}

TEST(Rate, BareNumber_NeedsAUnit) {
  expect_wrong(parse_rate("10"), QuantityCause::unit_missing, 2);
  expect_wrong(parse_rate("1.5"), QuantityCause::unit_missing, 3);
}

TEST(Rate, OutOfBounds_IsTooSmallOrTooLarge) {
  expect_wrong(parse_rate("0"), QuantityCause::too_small, 0);
  expect_wrong(parse_rate("0.0MHz"), QuantityCause::too_small, 0);
  expect_wrong(parse_rate("4.294967296GHz"), QuantityCause::too_large, 0);
  expect_wrong(parse_rate("5GHz"), QuantityCause::too_large, 0);
  expect_wrong(parse_rate("99999999999999999999999999999999Hz"), QuantityCause::too_large, 0);
  expect_wrong(parse_rate("18446744073709551617Hz"), QuantityCause::too_large, 0);
}

TEST(Rate, FinerThanOneHertz_PointsAtTheFirstDigitTooMany) {
  expect_wrong(parse_rate("1.5Hz"), QuantityCause::too_fine, 2);
  expect_wrong(parse_rate("1.0005kHz"), QuantityCause::too_fine, 5);
}

TEST(Duration, EveryUnit_IsExact) {
  EXPECT_EQ(duration("31.25us"), nanoseconds(31'250));
  EXPECT_EQ(duration("31.25 µs"), nanoseconds(31'250));
  EXPECT_EQ(duration("31.25\u03BCs"), nanoseconds(31'250));
  EXPECT_EQ(duration("42.5ns"), picoseconds(42'500));
  EXPECT_EQ(duration("7ps"), picoseconds(7));
  EXPECT_EQ(duration("3ms"), milliseconds(3));
  EXPECT_EQ(duration("1000s"), picoseconds(1'000 * picoseconds_per_second));
  EXPECT_EQ(duration("0"), picoseconds(0));
  EXPECT_EQ(duration("0s"), picoseconds(0));
}

TEST(Duration, OutOfBounds_IsTooLarge) {
  expect_wrong(parse_duration("1000.000000000001s"), QuantityCause::too_large, 0);
  expect_wrong(parse_duration("9999999s"), QuantityCause::too_large, 0);
}

TEST(Duration, BareNumber_NeedsAUnit) {
  expect_wrong(parse_duration("20"), QuantityCause::unit_missing, 2);
  expect_wrong(parse_duration("0.5"), QuantityCause::unit_missing, 3);
}

TEST(Duration, FinerThanAPicosecond_IsTooFine) {
  expect_wrong(parse_duration("0.5ps"), QuantityCause::too_fine, 2);
  expect_wrong(parse_duration("1.00005ns"), QuantityCause::too_fine, 6);
}

TEST(Length, EveryUnit_IsExact) {
  EXPECT_EQ(length("50m"), 50'000);
  EXPECT_EQ(length("0.5m"), 500);
  EXPECT_EQ(length("12cm"), 120);
  EXPECT_EQ(length("3mm"), 3);
  EXPECT_EQ(length("10km"), 10'000'000);
  EXPECT_EQ(length("0"), 0);
}

TEST(Time, EitherSign_IsExact) {
  EXPECT_EQ(*parse_time("-20us"), -microseconds(20));
  EXPECT_EQ(*parse_time("+3ms"), milliseconds(3));
  EXPECT_EQ(*parse_time("8640000s"), picoseconds(8'640'000 * picoseconds_per_second));
  EXPECT_EQ(*parse_time("0"), picoseconds(0));
  expect_wrong(parse_time("-20"), QuantityCause::unit_missing, 3);
  expect_wrong(parse_time("--20us"), QuantityCause::not_a_number, 1);
  expect_wrong(parse_time("-8640000.1s"), QuantityCause::too_large, 1);
}

TEST(Voltage, EitherSignAndEveryUnit_IsExact) {
  EXPECT_EQ(parse_voltage("1.2V")->count, 1'200'000'000);
  EXPECT_EQ(parse_voltage("-200 mV")->count, -200'000'000);
  EXPECT_EQ(parse_voltage("+3uV")->count, 3'000);
  EXPECT_EQ(parse_voltage("7nV")->count, 7);
  EXPECT_EQ(parse_voltage("-1000kV")->count, -1'000'000'000'000'000);
  EXPECT_EQ(parse_voltage("0")->count, 0);
  expect_wrong(parse_voltage("1.2"), QuantityCause::unit_missing, 3);
  expect_wrong(parse_voltage("--1V"), QuantityCause::not_a_number, 1);
  expect_wrong(parse_voltage("1000.1kV"), QuantityCause::too_large, 0);
  expect_wrong(parse_voltage("0.5nV"), QuantityCause::too_fine, 2);
}

TEST(Length, BareNumber_NeedsAUnit) {
  expect_wrong(parse_length("100"), QuantityCause::unit_missing, 3);
}

TEST(Length, OutOfBounds_IsTooLarge) {
  expect_wrong(parse_length("10.001km"), QuantityCause::too_large, 0);
  expect_wrong(parse_length("0.0005m"), QuantityCause::too_fine, 5);
}

TEST(Quantities, WrongText_PointsAtTheCharacter) {
  expect_wrong(parse_rate(""), QuantityCause::empty, 0);
  expect_wrong(parse_rate("-1MHz"), QuantityCause::negative, 0);
  expect_wrong(parse_rate("MHz"), QuantityCause::not_a_number, 0);
  expect_wrong(parse_rate(".5MHz"), QuantityCause::not_a_number, 0);
  expect_wrong(parse_rate("+5MHz"), QuantityCause::not_a_number, 0);
  expect_wrong(parse_rate(" 5MHz"), QuantityCause::not_a_number, 0);
  expect_wrong(parse_rate("5.MHz"), QuantityCause::not_a_number, 2);
  expect_wrong(parse_rate("1,5MHz"), QuantityCause::decimal_comma, 1);
  expect_wrong(parse_rate("1.5.2MHz"), QuantityCause::unknown_unit, 3);
  expect_wrong(parse_rate("1e6"), QuantityCause::unknown_unit, 1);
  expect_wrong(parse_rate("10mhz"), QuantityCause::unknown_unit, 2);
  expect_wrong(parse_rate("10  MHz"), QuantityCause::unknown_unit, 3);
  expect_wrong(parse_rate("10MHz "), QuantityCause::unknown_unit, 2);
  expect_wrong(parse_rate("10 "), QuantityCause::unknown_unit, 2);
  expect_wrong(parse_rate("10m"), QuantityCause::unknown_unit, 2);
  expect_wrong(parse_length("10s"), QuantityCause::unknown_unit, 2);
  expect_wrong(parse_rate(std::string_view("1\0", 2)), QuantityCause::unknown_unit, 1);
}

TEST(Count, DecimalAndHexadecimal_AreExact) {
  EXPECT_EQ(*parse_count("0"), 0U);
  EXPECT_EQ(*parse_count("18446744073709551615"), UINT64_MAX);
  EXPECT_EQ(*parse_count("0xFFFFFFFFFFFFFFFF"), UINT64_MAX);
  EXPECT_EQ(*parse_count("0x1aF"), 0x1AFU);
  EXPECT_EQ(*parse_count("010"), 10U);
  EXPECT_EQ(*parse_count("0000000000000000000000007", 7), 7U);
}

TEST(Count, WrongText_PointsAtTheCharacter) {
  expect_wrong(parse_count(""), QuantityCause::empty, 0);
  expect_wrong(parse_count("-1"), QuantityCause::negative, 0);
  expect_wrong(parse_count("+1"), QuantityCause::not_a_number, 0);
  expect_wrong(parse_count("0x"), QuantityCause::not_a_number, 2);
  expect_wrong(parse_count("0xG"), QuantityCause::not_a_number, 2);
  expect_wrong(parse_count("12a"), QuantityCause::not_a_number, 2);
  expect_wrong(parse_count("1.5"), QuantityCause::not_a_number, 1);
  expect_wrong(parse_count("18446744073709551616"), QuantityCause::too_large, 0);
  expect_wrong(parse_count("0x10000000000000000"), QuantityCause::too_large, 0);
  expect_wrong(parse_count("8", 7), QuantityCause::too_large, 0);
  expect_wrong(parse_count("1", 0), QuantityCause::too_large, 0);
  expect_wrong(parse_count("99999999999999999999999x"), QuantityCause::not_a_number, 23);
}

TEST(Errors, EveryCause_IsOneClearLine) {
  const auto rate_error = [](std::string_view text) {
    return quantity_error_text(Quantity::rate, text, parse_rate(text).error());
  };
  EXPECT_EQ(rate_error("10mhz"),
            "'10mhz': at character 3: unknown unit (did you mean MHz?); use Hz, kHz, MHz or GHz");
  EXPECT_EQ(rate_error("10m"), "'10m': at character 3: unknown unit; use Hz, kHz, MHz or GHz");
  EXPECT_EQ(rate_error("1,5MHz"), "'1,5MHz': at character 2: decimal comma; write '.'");
  EXPECT_EQ(rate_error("5GHz"),
            "'5GHz': too large; the range is 1 Hz to 4.294967295 GHz in steps of 1 Hz");
  EXPECT_EQ(rate_error(std::string(1'000, '9') + "Hz"),
            "'" + std::string(40, '9') +
                "...': too large; the range is 1 Hz to 4.294967295 GHz in steps of 1 Hz");
  EXPECT_EQ(quantity_error_text(Quantity::duration, "20", parse_duration("20").error()),
            "'20': no unit; use ps, ns, us, ms or s");
  EXPECT_EQ(quantity_error_text(Quantity::count, "1x", parse_count("1x").error()),
            "'1x': at character 2: not a number");
}

TEST(TextOf, Quantities_ReadWell) {
  EXPECT_EQ(text_of(megahertz(10)), "10 MHz");
  EXPECT_EQ(text_of(kilohertz(1'500)), "1.5 MHz");
  EXPECT_EQ(text_of(hertz(999)), "999 Hz");
  EXPECT_EQ(text_of(hertz(0)), "0 Hz");
  EXPECT_EQ(text_of(hertz(9'999'950), 3), "10 MHz");
  EXPECT_EQ(text_of(nanoseconds(31'250)), "31.25 us");
  EXPECT_EQ(text_of(picoseconds(42'500)), "42.5 ns");
  EXPECT_EQ(text_of(picoseconds(-42'500)), "-42.5 ns");
  EXPECT_EQ(text_of(picoseconds(112'345), 1), "112.3 ns");
  EXPECT_EQ(text_of(picoseconds(0)), "0 s");
  EXPECT_EQ(text_of(Millimetres{50'000}), "50 m");
  EXPECT_EQ(text_of(Millimetres{500}), "50 cm");
  EXPECT_EQ(text_of(Millimetres{0}), "0 m");
}

TEST(TextOf, RandomQuantities_ParseBackTheSame) {
  std::mt19937_64 random = test::random_of();
  for (int i = 0; i < 20'000; ++i) {
    const auto hz =
        hertz(static_cast<std::uint32_t>(1 + (random() % 0xFFFFFFFFU >> random() % 32)));
    ASSERT_EQ(rate(text_of(hz)), hz);
    const std::uint64_t most = 1'000'000'000'000'000U;
    const auto time =
        picoseconds(static_cast<std::int64_t>(random() % (most + 1) >> random() % 50));
    ASSERT_EQ(duration(text_of(time)), time);
    const Millimetres cable{static_cast<std::int64_t>(random() % 10'000'001U >> random() % 24)};
    ASSERT_EQ(length(text_of(cable)), cable.count);
  }
}

TEST(Quantities, RandomText_IsParsedOrRefusedWithAPlaceInside) {
  std::mt19937_64 random = test::random_of();
  const std::string alphabet = "0123456789.,-+ xXeEmkMGHznuspc\xC2\xB5\xCE\xBC\n\xff";
  for (int i = 0; i < 50'000; ++i) {
    std::string text;
    for (auto n = random() % 12; n > 0; --n) text += alphabet[random() % alphabet.size()];
    if (const auto r = parse_rate(text); !r) {
      ASSERT_LE(r.error().at, text.size());
      ASSERT_FALSE(quantity_error_text(Quantity::rate, text, r.error()).empty());
    }
    if (const auto d = parse_duration(text); !d) {
      ASSERT_LE(d.error().at, text.size());
      ASSERT_FALSE(quantity_error_text(Quantity::duration, text, d.error()).empty());
    } else {
      ASSERT_GE(d->count, 0);
    }
    if (const auto l = parse_length(text); !l) {
      ASSERT_LE(l.error().at, text.size());
      ASSERT_FALSE(quantity_error_text(Quantity::length, text, l.error()).empty());
    }
  }
}

TEST(Duty, Percent_IsInThousandths) {
  EXPECT_EQ(*parse_duty("45%"), 450U);
  EXPECT_EQ(*parse_duty("44.5 %"), 445U);
  EXPECT_EQ(*parse_duty("0.1%"), 1U);
  EXPECT_EQ(*parse_duty("99.9%"), 999U);
  expect_wrong(parse_duty("0%"), QuantityCause::too_small, 0);
  expect_wrong(parse_duty("100%"), QuantityCause::too_large, 0);
  expect_wrong(parse_duty("44.55%"), QuantityCause::too_fine, 4);
  expect_wrong(parse_duty("0"), QuantityCause::too_small, 0);
  expect_wrong(parse_duty("50"), QuantityCause::unit_missing, 2);
  expect_wrong(parse_duty("-1%"), QuantityCause::negative, 0);
}

TEST(Deviation, EitherSignAndUnit_IsInPartsOfAMillion) {
  EXPECT_EQ(*parse_deviation("200ppm"), 200);
  EXPECT_EQ(*parse_deviation("+200 ppm"), 200);
  EXPECT_EQ(*parse_deviation("-50ppm"), -50);
  EXPECT_EQ(*parse_deviation("-0.5%"), -5'000);
  EXPECT_EQ(*parse_deviation("10%"), 100'000);
  EXPECT_EQ(*parse_deviation("0"), 0);
  expect_wrong(parse_deviation("-10.0001%"), QuantityCause::too_large, 1);
  expect_wrong(parse_deviation("1.5ppm"), QuantityCause::too_fine, 2);
  expect_wrong(parse_deviation("-200"), QuantityCause::unit_missing, 4);
  expect_wrong(parse_deviation("200MHz"), QuantityCause::unknown_unit, 3);
  expect_wrong(parse_deviation("--5ppm"), QuantityCause::not_a_number, 1);
  expect_wrong(parse_deviation("-"), QuantityCause::empty, 1);
  EXPECT_EQ(quantity_error_text(Quantity::deviation, "5Ppm", parse_deviation("5Ppm").error()),
            "'5Ppm': at character 2: unknown unit (did you mean ppm?); use ppm or %");
}

TEST(Quantities, LocaleWithComma_ChangesNothing) {
  const std::locale old = std::locale::global(std::locale({}, new test::GermanPunctuation));
  EXPECT_EQ(rate("1.5MHz"), kilohertz(1'500));
  EXPECT_EQ(text_of(nanoseconds(31'250)), "31.25 us");
  EXPECT_FALSE(parse_rate("1,5MHz").ok());
  std::locale::global(old);
}

}  // namespace quantity_test
}  // namespace biss
