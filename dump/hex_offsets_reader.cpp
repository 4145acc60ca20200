// A binary as xxd and hexdump -C print it:
//
//     00000040: 0102 0000 6400 …  ....d...          xxd
//     00000040  01 02 00 00 64 00 …  |....d...|     hexdump -C
//     *                                             the last line over and over, up to the next
#include <vector>

#include "dump/hex_digits.hpp"
#include "dump/place.hpp"
#include "dump/read.hpp"

namespace biss::dump {
namespace {

// What one line may bring; xxd -c 256 is the widest there is.
constexpr std::size_t max_row_bytes = 256;

class HexOffsetsReader {
 public:
  HexOffsetsReader(LineSource& lines, const DumpOptions& options)
      : lines_(lines), options_(options) {}

  DumpResult read() {
    while (lines_.next()) {
      const std::string_view row = trimmed(lines_.line());
      if (row.empty() || row.front() == '#') continue;
      if (const auto error = take(row)) return failure(*error);
    }
    if (lines_.error()) return failure(*lines_.error());
    if (repeating_) {
      return failure(DumpError{DumpCause::truncated, lines_.number(), 0, "an offset behind the *"});
    }
    return dump_;
  }

 private:
  std::optional<DumpError> take(std::string_view row) {
    if (row == "*") {
      if (bytes_.empty()) {
        return lines_.error_at(row, DumpCause::malformed, "bytes before they are repeated");
      }
      repeating_ = true;
      return std::nullopt;
    }
    std::size_t digits = 0;
    while (digits < row.size() && hex_value(row[digits]) >= 0) ++digits;
    const auto offset = hex_number(row.substr(0, digits));
    const bool ended = digits == row.size() || row[digits] == ':' || is_blank(row[digits]);
    if (digits < 4 || !offset || !ended) {
      return lines_.error_at(row, DumpCause::malformed, "an offset of 4 to 8 hexadecimal digits");
    }
    if (repeating_) {
      if (const auto error = repeat_up_to(*offset, row)) return error;
    }
    const bool colon = digits < row.size() && row[digits] == ':';
    const auto error = colon ? take_xxd(row.substr(digits + 1)) : take_hexdump(row.substr(digits));
    if (error) return error;
    next_ = *offset;
    return put(row);
  }

  // Groups of any size up to two blanks, behind which the characters stand.
  std::optional<DumpError> take_xxd(std::string_view rest) {
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    rest = rest.substr(0, rest.find("  "));
    bytes_.clear();
    for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) {
      if (word.size() % 2 != 0) return not_hex(word, "groups of an even number of digits");
      for (std::size_t i = 0; i < word.size(); i += 2) {
        if (const auto error = take_byte(word.substr(i, 2))) return error;
      }
    }
    return std::nullopt;
  }

  std::optional<DumpError> take_hexdump(std::string_view rest) {
    rest = rest.substr(0, rest.find('|'));
    bytes_.clear();
    for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) {
      if (word.size() != 2) return not_hex(word, "single bytes, as hexdump -C prints them");
      if (const auto error = take_byte(word)) return error;
    }
    return std::nullopt;
  }

  std::optional<DumpError> take_byte(std::string_view digits) {
    const auto byte = hex_number(digits);
    if (!byte || bytes_.size() == max_row_bytes) return not_hex(digits, "two hexadecimal digits");
    bytes_.push_back(static_cast<std::uint8_t>(*byte));
    return std::nullopt;
  }

  DumpError not_hex(std::string_view place, const char* expected) const {
    return lines_.error_at(place, DumpCause::malformed, expected);
  }

  std::optional<DumpError> put(std::string_view row) {
    for (const std::uint8_t byte : bytes_) {
      if (const auto cause = place_at_offset(dump_, next_, byte, options_)) {
        return lines_.error_at(row, *cause);
      }
      ++next_;
    }
    return std::nullopt;
  }

  std::optional<DumpError> repeat_up_to(std::size_t offset, std::string_view row) {
    repeating_ = false;
    if (offset < next_ || (offset - next_) % bytes_.size() != 0) {
      return lines_.error_at(row, DumpCause::malformed, "an offset whole lines further on");
    }
    while (next_ < offset) {
      if (const auto error = put(row)) return error;
    }
    return std::nullopt;
  }

  LineSource& lines_;
  const DumpOptions& options_;
  RegisterDump dump_;
  std::vector<std::uint8_t> bytes_;  // of the last line
  std::size_t next_ = 0;             // the offset behind it
  bool repeating_ = false;
};

}  // namespace

DumpResult read_hex_offsets(LineSource& lines, const DumpOptions& options) {
  return HexOffsetsReader(lines, options).read();
}

}  // namespace biss::dump
