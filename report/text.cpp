#include "report/text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace biss::report {
namespace {

constexpr std::array<std::uint64_t, 19> powers_of_ten = [] {
  std::array<std::uint64_t, 19> powers{};
  std::uint64_t power = 1;
  for (auto& entry : powers) {
    entry = power;
    power *= 10;
  }
  return powers;
}();

constexpr std::string_view replacement = "\xEF\xBF\xBD";  // U+FFFD

// `digits` digits of `value`, zeros in front.
void append_digits(std::string& out, std::uint64_t value, unsigned digits) {
  std::array<char, 20> text;
  for (unsigned i = digits; i-- > 0; value /= 10) text[i] = static_cast<char>('0' + value % 10);
  out.append(text.data(), digits);
}

struct Range {
  char32_t first;
  char32_t last;
};

constexpr std::array no_width = {
    Range{0x0300, 0x036F}, Range{0x200B, 0x200F}, Range{0x202A, 0x202E}, Range{0x2060, 0x2064},
    Range{0x20D0, 0x20FF}, Range{0xFE00, 0xFE0F}, Range{0xFEFF, 0xFEFF}};
constexpr std::array double_width = {
    Range{0x1100, 0x115F},   Range{0x2E80, 0x303E},   Range{0x3041, 0xA4CF},  Range{0xAC00, 0xD7A3},
    Range{0xF900, 0xFAFF},   Range{0xFE30, 0xFE6F},   Range{0xFF00, 0xFF60},  Range{0xFFE0, 0xFFE6},
    Range{0x1F300, 0x1F64F}, Range{0x1F900, 0x1F9FF}, Range{0x20000, 0x3FFFD}};

template <std::size_t N>
bool lies_in(const std::array<Range, N>& ranges, char32_t value) {
  return std::any_of(ranges.begin(), ranges.end(),
                     [value](Range r) { return r.first <= value && value <= r.last; });
}

bool is_control(char32_t value) { return value < 0x20 || (value >= 0x7F && value < 0xA0); }

// These turn the direction of writing, so that a terminal shows another text than the file has.
bool turns_direction(char32_t value) {
  return (value >= 0x202A && value <= 0x202E) || (value >= 0x2066 && value <= 0x2069);
}

}  // namespace

char* put_number(char* at, std::uint64_t value) {
  return std::to_chars(at, at + number_chars, value).ptr;
}
char* put_number(char* at, std::int64_t value) {
  return std::to_chars(at, at + number_chars, value).ptr;
}
char* put_number(char* at, double value) {
  return std::isfinite(value) ? std::to_chars(at, at + number_chars, value).ptr : at;
}

char* put_nanoseconds(char* at, Picoseconds time) {
  const Magnitude number = magnitude_of(time.count);
  if (number.negative) *at++ = '-';
  at = put_number(at, number.value / 1000);
  const auto fraction = static_cast<unsigned>(number.value % 1000);
  if (fraction == 0) return at;
  const auto digit = [](unsigned value) { return static_cast<char>('0' + value % 10); };
  *at++ = '.';
  *at++ = digit(fraction / 100);
  if (fraction % 100 != 0) *at++ = digit(fraction / 10);
  if (fraction % 10 != 0) *at++ = digit(fraction);
  return at;
}

void append_fixed(std::string& out, Magnitude number, unsigned shift, unsigned places) {
  std::uint64_t kept = number.value;
  const unsigned kept_places = std::min(shift, places);
  if (shift > places) {
    const std::uint64_t divisor = powers_of_ten[shift - places];
    const std::uint64_t rest = kept % divisor;
    kept = kept / divisor + (rest >= divisor - rest ? 1U : 0U);
  }
  if (number.negative && kept != 0) out.push_back('-');
  append_number(out, kept / powers_of_ten[kept_places]);
  if (places == 0) return;
  out.push_back('.');
  append_digits(out, kept % powers_of_ten[kept_places], kept_places);
  out.append(places - kept_places, '0');
}

char* put_hex(char* at, BitView bits) {
  constexpr std::string_view digits = "0123456789ABCDEF";
  if (bits.empty()) return at;
  *at++ = '0';
  *at++ = 'x';
  // The first word has the bits that do not fill words of 32.
  auto taken = static_cast<unsigned>((bits.size_bits() - 1) % 32 + 1);
  for (std::size_t first = 0; first < bits.size_bits(); first += taken, taken = 32) {
    const std::uint64_t word = bits.word(first, taken);
    for (unsigned shift = (taken + 3) / 4 * 4; shift != 0;) {
      shift -= 4;
      *at++ = digits[word >> shift & 15U];
    }
  }
  return at;
}

CodePoint front_code_point(std::string_view text) {
  const auto byte = [text](std::size_t i) {
    return static_cast<char32_t>(static_cast<unsigned char>(text[i]));
  };
  const char32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  if (lead < 0xC2 || lead > 0xF4) return {};
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  if (text.size() < length) return {};
  char32_t value = lead & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return {};
    value = (value << 6U) | (byte(i) & 0x3FU);
  }
  constexpr std::array<char32_t, 5> smallest = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = value >= 0xD800 && value <= 0xDFFF;
  if (value < smallest[length] || value > 0x10FFFF || surrogate) return {};
  return {value, length, true};
}

void append_printable(std::string& out, std::string_view text) {
  while (!text.empty()) {
    const CodePoint point = front_code_point(text);
    const bool shown = point.valid && !is_control(point.value) && !turns_direction(point.value);
    out.append(shown ? text.substr(0, point.bytes) : replacement);
    text.remove_prefix(point.bytes);
  }
}

void append_printable_lines(std::string& out, std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\n\t"), text.size());
    append_printable(out, text.substr(0, end));
    text.remove_prefix(end);
    if (text.empty()) return;
    out.push_back(text.front());
    text.remove_prefix(1);
  }
}

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    const CodePoint point = front_code_point(text);
    text.remove_prefix(point.bytes);
    if (point.value < 0x300) {
      ++width;
    } else if (!lies_in(no_width, point.value)) {
      width += lies_in(double_width, point.value) ? 2U : 1U;
    }
  }
  return width;
}

void append_padded(std::string& out, std::string_view text, std::size_t width, bool right_aligned) {
  const std::size_t taken = display_width(text);
  const std::size_t spaces = width > taken ? width - taken : 0;
  if (right_aligned) out.append(spaces, ' ');
  out.append(text);
  if (!right_aligned) out.append(spaces, ' ');
}

void append_wrapped(std::string& out, std::string_view text, Wrap wrap) {
  std::size_t column = wrap.first;
  bool first = true;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(' '));
    if (!first && column + 1 + word.size() > wrap.width) {
      out += '\n' + std::string(wrap.indent, ' ');
      column = wrap.indent;
    } else if (!first) {
      out += ' ';
      ++column;
    }
    out += word;
    column += word.size();
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    first = false;
  }
}

}  // namespace biss::report
