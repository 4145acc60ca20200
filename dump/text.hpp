// Text of dumps and descriptions: lines in bounded memory, words, hexadecimal numbers, and errors
// that name their place.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace biss::dump {

/// The formats of dumps; docs/eds.md describes them.
enum class DumpFormat : std::uint8_t {
  binary,       ///< banks of 64 bytes, one after the other
  hex_page,     ///< `0x40: 00 02 62 1E …` by register address
  hex_offsets,  ///< as xxd and hexdump -C print a binary
  intel_hex,    ///< records by offset
  json_lines,   ///< accesses, as `biss registers --to jsonl` prints them
};

/// The formats for a message.
inline constexpr std::string_view known_formats =
    "hex text (0x40: 00 1A), xxd or hexdump -C, Intel HEX, JSON lines of accesses, binary banks of "
    "64 bytes";

/// Why a dump cannot be read: one enumerator per cause.
enum class DumpCause : std::uint8_t {
  read_failed,      ///< the system reports a read error
  empty,            ///< no byte, or only white space and comments
  unknown_format,   ///< text in none of the formats
  malformed,        ///< a line that the format does not allow
  line_too_long,    ///< a line longer than any valid one
  not_whole_banks,  ///< binary whose size is not a multiple of 64
  outside,          ///< an address or offset at which there is no register
  checksum,         ///< a record of Intel HEX whose bytes do not add up to 0
  contradiction,    ///< a byte given twice, with different values
  several_slaves,   ///< accesses to more than one slave, and no slave was selected
  nothing_read,     ///< no access that returned a byte (from the selected slave)
  truncated,        ///< the file ends earlier than its format requires
};

struct DumpError {
  DumpCause cause{};
  /// From 1, columns in bytes; 0 if they have no meaning.
  std::uint64_t line = 0;
  std::uint64_t column = 0;
  /// The valid content at this place; static text, or null.
  const char* expected = nullptr;
  /// The format that the file was read as; empty if it has none.
  std::optional<DumpFormat> format{};
};

/// The name of a cause, the same as its enumerator.
const char* name_of(DumpCause cause);

/// One line for a message: "read as hex text: line 3, column 7: expected two hexadecimal digits".
std::string dump_error_text(const DumpError& error);

/// Longer lines are refused: the longest that `biss registers --to jsonl` writes has a few hundred
/// bytes.
inline constexpr std::size_t max_line_bytes = 16'384;

/// The lines of a stream in bounded memory.
class LineSource {
 public:
  /// \param head the bytes already read from the stream \pre the stream outlives the source
  LineSource(std::istream& stream, std::string head);

  /// Reads the next line. False at the end and after an error: `line_too_long`, `read_failed`.
  bool next();
  /// The next line that is not empty without its `#` comment, trimmed; empty at the end. Throws
  /// error().
  std::string_view next_row();
  /// The line without its line feed; valid until next().
  std::string_view line() const { return line_; }
  /// From 1.
  std::uint64_t number() const { return number_; }
  const std::optional<DumpError>& error() const { return error_; }

  /// An error at `place`, which is a part of line().
  DumpError error_at(std::string_view place, DumpCause cause, const char* expected = nullptr) const;

 private:
  int peek();
  int take();

  std::istream& stream_;
  std::string head_;
  std::size_t at_ = 0;  // in the head
  std::string line_;
  std::uint64_t number_ = 0;
  std::optional<DumpError> error_;
};

/// White space within a line.
inline constexpr std::string_view blanks = " \t\r";
constexpr bool is_blank(char c) { return blanks.find(c) != std::string_view::npos; }

/// Without white space at both ends.
constexpr std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

/// A line without its `#` comment, trimmed.
constexpr std::string_view without_comment(std::string_view line) {
  return trimmed(line.substr(0, line.find('#')));
}

/// The first line of a text that is not empty without its comment; empty if there is no such line.
std::string_view first_row(std::string_view text);

/// Removes the next word from the front of `rest`; empty at the end.
constexpr std::string_view next_word(std::string_view& rest) {
  rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
  const std::string_view word = rest.substr(0, rest.find_first_of(blanks));
  rest.remove_prefix(word.size());
  return word;
}

/// The value of a hexadecimal digit; -1 for other characters.
constexpr int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// How many hexadecimal digits a text begins with.
constexpr std::size_t hex_digits_at_front(std::string_view text) {
  return std::min(text.find_first_not_of("0123456789ABCDEFabcdef"), text.size());
}

/// The number in up to 8 digits of this base, 10 or 16; empty for any other text.
constexpr std::optional<std::uint32_t> number_in_base(std::string_view text, unsigned base) {
  if (text.empty() || text.size() > 8) return std::nullopt;
  std::uint32_t number = 0;
  for (const char c : text) {
    const int digit = hex_value(c);
    if (digit < 0 || digit >= static_cast<int>(base)) return std::nullopt;
    number = number * base + static_cast<std::uint32_t>(digit);
  }
  return number;
}

/// Hexadecimal digits without prefix.
constexpr std::optional<std::uint32_t> hex_number(std::string_view text) {
  return number_in_base(text, 16);
}

/// `0x` and hexadecimal digits; empty for any other text.
constexpr std::optional<std::uint32_t> prefixed_hex_number(std::string_view text) {
  const bool prefixed = text.starts_with("0x") || text.starts_with("0X");
  return prefixed ? hex_number(text.substr(2)) : std::nullopt;
}

/// Decimal digits, or `0x` and hexadecimal ones.
constexpr std::optional<std::uint32_t> any_number(std::string_view text) {
  const auto number = prefixed_hex_number(text);
  return number ? number : number_in_base(text, 10);
}

/// The byte in exactly two hexadecimal digits; empty for any other text.
constexpr std::optional<std::uint8_t> hex_byte(std::string_view text) {
  const auto number = text.size() == 2 ? hex_number(text) : std::nullopt;
  return number ? std::optional(static_cast<std::uint8_t>(*number)) : std::nullopt;
}

}  // namespace biss::dump
