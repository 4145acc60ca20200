// The numbers of the page against those of the C++ library of the command.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <random>
#include <string>
#include <string_view>

#include "tests/common/long_run.hpp"
#include "wasm/compat.hpp"

namespace biss::real_numbers_test {

constexpr double untouched = -123.5;

void expect_read_alike(const std::string& text) {
  double value = untouched;
  double expected = untouched;
  const auto [at, error] = wasm::from_chars(text.data(), text.data() + text.size(), value);
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), expected);
  EXPECT_EQ(error, failed) << text;
  EXPECT_EQ(at, end) << text;
  EXPECT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(expected)) << text;
}

std::string written(double value, std::size_t room = 64) {
  std::array<char, 64> text{};
  const auto [end, error] = wasm::to_chars(text.data(), text.data() + room, value);
  if (error == std::errc{}) return {text.data(), end};
  EXPECT_EQ(error, std::errc::value_too_large);
  EXPECT_EQ(end, text.data() + room);
  return "does not fit";
}

void expect_written_alike(double value) {
  std::array<char, 64> text{};
  const std::string expected(text.data(),
                             std::to_chars(text.data(), text.data() + text.size(), value).ptr);
  EXPECT_EQ(written(value), expected);
  EXPECT_EQ(written(value, expected.size()), expected);
  EXPECT_EQ(written(value, expected.size() - 1), "does not fit");
}

TEST(RealNumbers, HostileText_IsReadAsByTheLibrary) {
  for (const char* text : {"",
                           "-",
                           ".",
                           "-.",
                           "+",
                           "+1",
                           "-+1",
                           "--1",
                           "e",
                           "e5",
                           "-e5",
                           ".e5",
                           "0",
                           "-0",
                           "00",
                           "0.",
                           ".5",
                           "5.",
                           "-.5e1",
                           "1e",
                           "1e+",
                           "1e-",
                           "1e+5",
                           "1E5",
                           "1e5.5",
                           "1.2.3",
                           "1-2",
                           "0-5",
                           "0e5",
                           "0e999",
                           "-0e-999",
                           "0.000e5",
                           "0.0001e0",
                           "1e999",
                           "-1e999",
                           "1e-999",
                           "-1e-999",
                           "1e99999999999999999999",
                           "1e-99999999999999999999",
                           "1e308",
                           "1.7976931348623157e308",
                           "1.7976931348623159e308",
                           "5e-324",
                           "2e-324",
                           "4.9e-324",
                           "1e-310",
                           " 1",
                           "1 ",
                           "\t1",
                           "0x10",
                           "0X1p3",
                           "1p3",
                           "1,5",
                           "1_000",
                           "1'000",
                           "1e5e5",
                           "x",
                           "1x"}) {
    expect_read_alike(text);
  }
  for (const std::size_t digits : {62U, 63U, 64U, 70U, 308U, 309U, 400U, 2'000U}) {
    expect_read_alike(std::string(digits, '1'));
    expect_read_alike("-" + std::string(digits, '9') + "e-100x");
    expect_read_alike("0." + std::string(digits, '0') + "1");
    expect_read_alike(std::string(digits, '0') + "7");
  }
  expect_read_alike(std::string("1\0002", 3));
}

TEST(RealNumbers, InfinityAndNan_AreNoText) {
  for (const std::string_view text : {"inf", "-inf", "infinity", "nan", "-nan", "nan(1)"}) {
    double value = untouched;
    const auto [at, error] = wasm::from_chars(text.data(), text.data() + text.size(), value);
    EXPECT_EQ(error, std::errc::invalid_argument) << text;
    EXPECT_EQ(at, text.data()) << text;
    EXPECT_EQ(value, untouched) << text;
  }
}

TEST(RealNumbers, RandomText_IsReadAsByTheLibrary) {
  std::mt19937_64 random(7);
  constexpr std::string_view characters = "0123456789012345678901234567890000999..--+eE x";
  const std::uint64_t rounds = test::rounds(100'000, 20'000);
  for (std::uint64_t round = 0; round < rounds; ++round) {
    std::string text(random() % 30, ' ');
    for (char& c : text) c = characters[random() % characters.size()];
    expect_read_alike(text);
  }
}

TEST(RealNumbers, ExtremeNumbers_AreWrittenAsByTheLibrary) {
  using Limits = std::numeric_limits<double>;
  for (const double value :
       {0.0, 1.0, 9.5, 0.001, 0.0001, 1e5, 1e15, 1e16, 1e21, 1e22, 1e23, 123456789012345678.0,
        9007199254740993.0, Limits::max(), Limits::min(), Limits::denorm_min(), Limits::epsilon(),
        Limits::infinity(), Limits::quiet_NaN()}) {
    expect_written_alike(value);
    expect_written_alike(-value);
  }
  for (int exponent = -1'074; exponent < 1'024; ++exponent) {
    const double power = std::ldexp(1.0, exponent);
    expect_written_alike(power);
    expect_written_alike(std::nextafter(power, 0.0));
    expect_written_alike(std::nextafter(power, Limits::max()));
  }
  for (int exponent = -323; exponent < 309; ++exponent) {
    expect_written_alike(std::strtod(("1e" + std::to_string(exponent)).c_str(), nullptr));
  }
}

TEST(RealNumbers, RandomNumbers_AreWrittenAsByTheLibrary) {
  std::mt19937_64 random(8);
  for (int round = 0; round < 100'000; ++round) {
    expect_written_alike(std::bit_cast<double>(random()));
    // As rows have them: angles, millimetres, microseconds.
    const auto digits = static_cast<double>(random() >> (random() % 54 + 10));
    expect_written_alike(digits / std::exp2(random() % 64));
    expect_written_alike(digits / std::pow(10.0, static_cast<double>(random() % 16)));
  }
}

}  // namespace biss::real_numbers_test
