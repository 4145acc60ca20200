#include "device/quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <span>
#include <type_traits>

#include "report/text.hpp"

namespace biss {
namespace {

// A unit is worth 10^exponent of the smallest step.
struct Unit {
  std::string_view name;
  unsigned exponent;
};

struct Scale {
  std::span<const Unit> units;  // from small to large; the last name of an exponent is printed
  std::uint64_t least;          // of the magnitude
  std::uint64_t greatest;
  std::string_view unit_names;
  std::string_view range;
};

constexpr std::array rate_units = {Unit{"Hz", 0}, Unit{"kHz", 3}, Unit{"MHz", 6}, Unit{"GHz", 9}};
// Both characters that look like a micro sign are in use: U+00B5 and the Greek letter.
constexpr std::array duration_units = {Unit{"ps", 0},      Unit{"ns", 3}, Unit{"\u00B5s", 6},
                                       Unit{"\u03BCs", 6}, Unit{"us", 6}, Unit{"ms", 9},
                                       Unit{"s", 12}};
constexpr std::array length_units = {Unit{"mm", 0}, Unit{"cm", 1}, Unit{"m", 3}, Unit{"km", 6}};
constexpr std::array duty_units = {Unit{"%", 1}};
constexpr std::array deviation_units = {Unit{"ppm", 0}, Unit{"%", 4}};

constexpr std::array voltage_units = {Unit{"nV", 0}, Unit{"uV", 3}, Unit{"mV", 6}, Unit{"V", 9},
                                      Unit{"kV", 12}};

constexpr auto second = static_cast<std::uint64_t>(picoseconds_per_second);
constexpr std::string_view time_names = "ps, ns, us, ms or s";

// In the order of Quantity; a count has no unit.
constexpr Scale scales[] = {
    {rate_units, 1, UINT32_MAX, "Hz, kHz, MHz or GHz", "1 Hz to 4.294967295 GHz in steps of 1 Hz"},
    {duration_units, 0, 1000 * second, time_names, "0 to 1000 s in steps of 1 ps"},
    {duration_units, 0, 100 * 24 * 3600 * second, time_names,
     "-8640000 s to 8640000 s (100 days) in steps of 1 ps"},
    {length_units, 0, 10'000'000, "mm, cm, m or km", "0 to 10 km in steps of 1 mm"},
    {duty_units, 1, 999, "%", "0.1 % to 99.9 % in steps of 0.1 %"},
    {deviation_units, 0, 100'000, "ppm or %", "-10 % to 10 % in steps of 1 ppm"},
    {voltage_units, 0, 1'000'000'000'000'000, "nV, uV, mV, V or kV",
     "-1000 kV to 1000 kV in steps of 1 nV"},
    {}};

const Scale& scale_of(Quantity quantity) { return scales[static_cast<std::size_t>(quantity)]; }

using Parsed = Result<std::uint64_t, QuantityError>;

Failure<QuantityError> wrong(QuantityCause cause, std::size_t at) {
  return failure(QuantityError{cause, at});
}

std::size_t skip_digits(std::string_view text, std::size_t at) {
  return std::min(text.find_first_not_of("0123456789", at), text.size());
}

// The parts of the number at the front of a text.
struct Number {
  std::size_t end = 0;
  std::size_t point = 0;  // the place of the decimal point; `end` if there is none
};

Result<Number, QuantityError> scan_number(std::string_view text) {
  if (text.empty()) return wrong(QuantityCause::empty, 0);
  if (text[0] == '-') return wrong(QuantityCause::negative, 0);
  const std::size_t whole = skip_digits(text, 0);
  if (whole == 0) return wrong(QuantityCause::not_a_number, 0);
  if (whole == text.size()) return Number{whole, whole};
  if (text[whole] == ',') return wrong(QuantityCause::decimal_comma, whole);
  if (text[whole] != '.') return Number{whole, whole};
  const std::size_t end = skip_digits(text, whole + 1);
  if (end == whole + 1) return wrong(QuantityCause::not_a_number, end);
  return Number{end, whole};
}

// The digits times 10^exponent; a digit that would be less than one step must be 0.
Parsed scale_number(std::string_view text, Number number, unsigned exponent,
                    std::uint64_t greatest) {
  std::uint64_t value = 0;
  const auto push = [&value, greatest](unsigned digit) {
    if (value > (greatest - digit) / 10) return false;
    value = value * 10 + digit;
    return true;
  };
  unsigned places = 0;
  for (std::size_t i = 0; i < number.end; ++i) {
    if (i == number.point) continue;
    const auto digit = static_cast<unsigned>(text[i] - '0');
    if (i > number.point && places == exponent) {
      if (digit != 0) return wrong(QuantityCause::too_fine, i);
      continue;
    }
    if (i > number.point) ++places;
    if (!push(digit)) return wrong(QuantityCause::too_large, 0);
  }
  for (; places < exponent; ++places) {
    if (!push(0)) return wrong(QuantityCause::too_large, 0);
  }
  return value;
}

Parsed parse(std::string_view text, const Scale& scale) {
  const auto number = scan_number(text);
  if (!number) return failure(number.error());
  std::size_t unit_at = number->end;
  if (unit_at + 1 < text.size() && text[unit_at] == ' ') ++unit_at;
  const std::string_view name = text.substr(unit_at);
  if (name.empty()) {
    const bool zero = text.find_first_not_of("0.") == std::string_view::npos;
    if (!zero) return wrong(QuantityCause::unit_missing, unit_at);
    if (scale.least != 0) return wrong(QuantityCause::too_small, 0);
    return std::uint64_t{0};
  }
  for (const Unit& unit : scale.units) {
    if (unit.name != name) continue;
    const Parsed value = scale_number(text, *number, unit.exponent, scale.greatest);
    if (value && *value < scale.least) return wrong(QuantityCause::too_small, 0);
    return value;
  }
  return wrong(QuantityCause::unknown_unit, unit_at);
}

// The same with a sign in front.
Result<std::int64_t, QuantityError> parse_signed(std::string_view text, const Scale& scale) {
  const bool negative = text.starts_with('-');
  const std::size_t sign = negative || text.starts_with('+') ? 1 : 0;
  const Parsed value = parse(text.substr(sign), scale);
  if (value)
    return negative ? -static_cast<std::int64_t>(*value) : static_cast<std::int64_t>(*value);
  const QuantityError error = value.error();
  // A second sign.
  if (error.cause == QuantityCause::negative) return wrong(QuantityCause::not_a_number, sign);
  return wrong(error.cause, error.at + sign);
}

// The quantity that a scale holds as this number.
template <class Made, class Number>
Result<Made, QuantityError> made(const Result<Number, QuantityError>& number) {
  if (!number) return failure(number.error());
  if constexpr (std::is_integral_v<Made>) {
    return static_cast<Made>(*number);
  } else {
    return Made{static_cast<decltype(Made::count)>(*number)};
  }
}

// `Mhz` -> ` (did you mean MHz?)`: a unit that differs in case only.
std::string other_case(const Scale& scale, std::string_view name) {
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  const auto same = [&](char a, char b) { return lower(a) == lower(b); };
  for (const auto& [unit, exponent] : scale.units) {
    if (std::equal(unit.begin(), unit.end(), name.begin(), name.end(), same)) {
      return fmt::format(" (did you mean {}?)", unit);
    }
  }
  return {};
}

std::string cause_text(Quantity quantity, std::string_view text, QuantityError error,
                       std::uint64_t largest) {
  const Scale& scale = scale_of(quantity);
  const std::string range =
      quantity == Quantity::count ? fmt::format("0 to {}", largest) : std::string(scale.range);
  switch (error.cause) {
    case QuantityCause::empty:
      return "empty; a value is needed";
    case QuantityCause::negative:
      return fmt::format("negative; the range is {}", range);
    case QuantityCause::not_a_number:
      return "not a number";
    case QuantityCause::decimal_comma:
      return "decimal comma; write '.'";
    case QuantityCause::unit_missing:
      return fmt::format("no unit; use {}", scale.unit_names);
    case QuantityCause::unknown_unit:
      return fmt::format("unknown unit{}; use {}", other_case(scale, text.substr(error.at)),
                         scale.unit_names);
    case QuantityCause::too_fine:
      return fmt::format("too many decimal places; the range is {}", range);
    case QuantityCause::too_small:
      return fmt::format("too small; the range is {}", range);
    case QuantityCause::too_large:
      return fmt::format("too large; the range is {}", range);
  }
  return {};
}

std::string format(report::Magnitude number, const Scale& scale, unsigned max_places) {
  const Unit* unit = &scale.units.front();
  std::uint64_t worth = 1;
  unsigned exponent = 0;
  for (const Unit& candidate : scale.units) {
    for (; exponent < candidate.exponent; ++exponent) worth *= 10;
    if (number.value >= worth) unit = &candidate;
  }
  std::string out;
  report::append_fixed(out, number, unit->exponent, std::min(unit->exponent, max_places));
  if (out.find('.') != std::string::npos) {
    while (out.back() == '0') out.pop_back();
    if (out.back() == '.') out.pop_back();
  }
  return out.append(" ").append(unit->name);
}

}  // namespace

Result<Hertz, QuantityError> parse_rate(std::string_view text) {
  return made<Hertz>(parse(text, scale_of(Quantity::rate)));
}

Result<Picoseconds, QuantityError> parse_duration(std::string_view text) {
  return made<Picoseconds>(parse(text, scale_of(Quantity::duration)));
}

Result<Picoseconds, QuantityError> parse_time(std::string_view text) {
  return made<Picoseconds>(parse_signed(text, scale_of(Quantity::time)));
}

Result<Millimetres, QuantityError> parse_length(std::string_view text) {
  return made<Millimetres>(parse(text, scale_of(Quantity::length)));
}

Result<std::uint32_t, QuantityError> parse_duty(std::string_view text) {
  return made<std::uint32_t>(parse(text, scale_of(Quantity::duty)));
}

Result<std::int32_t, QuantityError> parse_deviation(std::string_view text) {
  return made<std::int32_t>(parse_signed(text, scale_of(Quantity::deviation)));
}

Result<Nanovolts, QuantityError> parse_voltage(std::string_view text) {
  return made<Nanovolts>(parse_signed(text, scale_of(Quantity::voltage)));
}

Result<std::uint64_t, QuantityError> parse_count(std::string_view text, std::uint64_t largest) {
  if (text.empty()) return wrong(QuantityCause::empty, 0);
  if (text[0] == '-') return wrong(QuantityCause::negative, 0);
  const bool hex = text.starts_with("0x") || text.starts_with("0X");
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data() + (hex ? 2 : 0), end, value, hex ? 16 : 10);
  if (at != end || error == std::errc::invalid_argument) {
    return wrong(QuantityCause::not_a_number, static_cast<std::size_t>(at - text.data()));
  }
  if (error != std::errc() || value > largest) return wrong(QuantityCause::too_large, 0);
  return value;
}

std::string quantity_error_text(Quantity quantity, std::string_view text, QuantityError error,
                                std::uint64_t largest) {
  // The other causes concern the whole text.
  const bool place =
      error.cause == QuantityCause::decimal_comma || error.cause == QuantityCause::unknown_unit ||
      error.cause == QuantityCause::too_fine || error.cause == QuantityCause::not_a_number;
  const std::string where = place ? fmt::format("at character {}: ", error.at + 1) : "";
  constexpr std::size_t longest_shown = 40;
  const bool cut = text.size() > longest_shown;
  return fmt::format("'{}{}': {}{}", text.substr(0, longest_shown), cut ? "..." : "", where,
                     cause_text(quantity, text, error, largest));
}

std::string text_of(Hertz rate, unsigned max_places) {
  return format({rate.count, false}, scale_of(Quantity::rate), max_places);
}

std::string text_of(Picoseconds duration, unsigned max_places) {
  if (duration == Picoseconds{}) return "0 s";
  return format(report::magnitude_of(duration.count), scale_of(Quantity::duration), max_places);
}

std::string text_of(Millimetres length, unsigned max_places) {
  if (length == Millimetres{}) return "0 m";
  return format(report::magnitude_of(length.count), scale_of(Quantity::length), max_places);
}

}  // namespace biss
