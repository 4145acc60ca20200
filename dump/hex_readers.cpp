// The formats that write bytes as hexadecimal digits. `#` begins a comment in each of them.
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "dump/readers.hpp"

namespace biss::dump {
namespace {

// Shared by the readers: Reader::take() reads a row, Reader::finish() returns the dump.
template <class Reader>
class HexReader {
 public:
  HexReader(LineSource& lines, const DumpOptions& options) : lines_(lines), options_(options) {}

  DumpResult read() {
    while (lines_.next()) {
      const std::string_view row = without_comment(lines_.line());
      if (row.empty()) continue;
      if (const auto error = self().take(row)) return tl::unexpected(*error);
    }
    if (lines_.error()) return tl::unexpected(*lines_.error());
    return self().finish();
  }

 protected:
  DumpError malformed(std::string_view place, const char* expected) const {
    return lines_.error_at(place, DumpCause::malformed, expected);
  }
  DumpResult truncated(const char* expected) const {
    return tl::unexpected(
        DumpError{DumpCause::truncated, lines_.number(), 0, expected, std::nullopt});
  }
  // Sets bytes from an offset on.
  std::optional<DumpError> put(std::string_view row, std::size_t offset,
                               std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      if (const auto cause = set_byte_at_offset(dump_, offset++, byte, options_)) {
        return lines_.error_at(row, *cause);
      }
    }
    return std::nullopt;
  }

  LineSource& lines_;
  const DumpOptions& options_;
  RegisterDump dump_;

 private:
  Reader& self() { return static_cast<Reader&>(*this); }
};

// Registers by address, as people write them:
//
//     bank 2                      # the registers 0x00…0x3F that follow are in this bank
//     0x00: 01 02 -- xN           # a byte, a missing one, the last one N times in all
//     0x40: 02 01 62 1E
class HexPageReader : public HexReader<HexPageReader> {
 public:
  using HexReader::HexReader;

  std::optional<DumpError> take(std::string_view row) {
    std::string_view rest = row;
    if (next_word(rest) == "bank") return take_heading(rest);
    const std::size_t colon = std::min(row.find(':'), row.size());
    const auto address = prefixed_hex_number(row.substr(0, colon));
    if (colon == row.size() || !address) return malformed(row, "'0x00: 48 44 --' or 'bank 2'");
    if (*address > last_address) {
      return lines_.error_at(row, DumpCause::outside, "an address up to 0x7F");
    }
    return take_bytes(*address, row.substr(colon + 1));
  }

  // The bank of registers without a heading is known only now.
  DumpResult finish() {
    const unsigned bank = options_.bank.value_or(dump_.direct_byte(reg::bsel).value_or(0));
    for (unsigned i = 0; i < window_.size(); ++i) {
      if (!window_[i]) continue;
      if (const auto cause = set_byte(dump_.at(bank, i), *window_[i])) {
        return tl::unexpected(DumpError{*cause});
      }
    }
    return dump_;
  }

 private:
  std::optional<DumpError> take_heading(std::string_view rest) {
    std::string_view word = next_word(rest);
    if (word.ends_with(':')) word.remove_suffix(1);
    const auto number = any_number(word);
    if (!number || *number >= bank_count || !trimmed(rest).empty()) {
      return malformed(word, "the number of a bank, 0 to 255");
    }
    bank_ = *number;
    return std::nullopt;
  }

  std::optional<DumpError> take_bytes(unsigned address, std::string_view rest) {
    constexpr const char* expected = "two hexadecimal digits, -- or x and a count";
    std::optional<std::uint8_t> last;
    bool first = true;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      std::uint32_t times = 1;
      if (word.starts_with('x') && !first) {
        const auto count = any_number(word.substr(1));
        if (!count || *count == 0) return malformed(word, expected);
        times = std::min(*count, last_address + 2U) - 1;
      } else {
        last = hex_byte(word);
        if (!last && word != "--") return malformed(word, expected);
      }
      first = false;
      for (; times != 0; --times, ++address) {
        if (address > last_address) {
          return lines_.error_at(word, DumpCause::outside, "addresses up to 0x7F");
        }
        if (const auto cause = take_byte(address, last)) return lines_.error_at(word, *cause);
      }
    }
    return std::nullopt;
  }

  std::optional<DumpCause> take_byte(unsigned address, std::optional<std::uint8_t> byte) {
    if (!byte) return std::nullopt;
    auto& at =
        address < first_direct && !bank_ ? window_[address] : dump_.at(bank_.value_or(0), address);
    // `byte` has a value, but GCC 12 at -O3 does not see that and warns about *byte.
    return set_byte(at, byte.value_or(0));
  }

  DumpedBytes window_{};  // registers 0x00…0x3F before any heading
  std::optional<unsigned> bank_;
};

// A binary as xxd and hexdump -C print it:
//
//     00000040: 0102 0000 6400 …  ....d...          xxd
//     00000040  01 02 00 00 64 00 …  |....d...|     hexdump -C
//     *                                             the last line repeated, up to the next offset
class HexOffsetsReader : public HexReader<HexOffsetsReader> {
 public:
  using HexReader::HexReader;

  std::optional<DumpError> take(std::string_view row) {
    if (row == "*") {
      if (bytes_.empty()) return malformed(row, "bytes before they are repeated");
      repeating_ = true;
      return std::nullopt;
    }
    const std::size_t digits = hex_digits_at_front(row);
    const auto offset = hex_number(row.substr(0, digits));
    const bool ended = digits == row.size() || row[digits] == ':' || is_blank(row[digits]);
    if (digits < 4 || !offset || !ended) {
      return malformed(row, "an offset of 4 to 8 hexadecimal digits");
    }
    if (repeating_) {
      if (const auto error = repeat_up_to(*offset, row)) return error;
    }
    const bool xxd = digits < row.size() && row[digits] == ':';
    const std::string_view rest =
        xxd ? bytes_of_xxd(row.substr(digits + 1)) : row.substr(digits, row.find('|') - digits);
    if (const auto error = take_words(rest, xxd)) return error;
    next_ = *offset;
    return put_row(row);
  }

  DumpResult finish() {
    if (repeating_) return truncated("an offset after the *");
    return dump_;
  }

 private:
  // xxd -c 256 is the widest there is.
  static constexpr std::size_t max_row_bytes = 256;

  // xxd prints groups of any size up to two blanks, after which the characters follow.
  static std::string_view bytes_of_xxd(std::string_view rest) {
    rest = rest.substr(std::min(rest.find_first_not_of(" \t\r"), rest.size()));
    return rest.substr(0, rest.find("  "));
  }

  std::optional<DumpError> take_words(std::string_view rest, bool groups) {
    bytes_.clear();
    for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) {
      if (groups ? word.size() % 2 != 0 : word.size() != 2) {
        return malformed(word, groups ? "groups of an even number of digits"
                                      : "single bytes, as hexdump -C prints them");
      }
      for (std::size_t i = 0; i < word.size(); i += 2) {
        if (const auto error = take_byte(word.substr(i, 2))) return error;
      }
    }
    return std::nullopt;
  }

  std::optional<DumpError> take_byte(std::string_view digits) {
    const auto byte = hex_byte(digits);
    if (!byte || bytes_.size() == max_row_bytes) return malformed(digits, "two hexadecimal digits");
    bytes_.push_back(*byte);
    return std::nullopt;
  }

  std::optional<DumpError> put_row(std::string_view row) {
    const auto error = put(row, next_, bytes_);
    next_ += bytes_.size();
    return error;
  }

  std::optional<DumpError> repeat_up_to(std::size_t offset, std::string_view row) {
    repeating_ = false;
    if (offset < next_ || (offset - next_) % bytes_.size() != 0) {
      return malformed(row, "an offset that is larger by a whole number of lines");
    }
    while (next_ < offset) {
      if (const auto error = put_row(row)) return error;
    }
    return std::nullopt;
  }

  std::vector<std::uint8_t> bytes_;  // of the last line
  std::size_t next_ = 0;             // the offset after it
  bool repeating_ = false;
};

// Intel HEX. The offset is the register's place: bank b begins at 64 b, the registers 0x40…0x7F at
// 0x4000.
class IntelHexReader : public HexReader<IntelHexReader> {
 public:
  using HexReader::HexReader;

  std::optional<DumpError> take(std::string_view row) {
    if (ended_) return malformed(row, "nothing after the end record");
    if (row.front() != ':') return malformed(row, "a record that begins with a colon");
    std::string_view digits = row.substr(1);
    if (digits.size() % 2 != 0 || digits.size() / 2 > max_record_bytes) {
      return malformed(row, "pairs of digits, at most 260 of them");
    }
    std::array<std::uint8_t, max_record_bytes> record{};
    std::size_t size = 0;
    unsigned sum = 0;
    for (; !digits.empty(); digits.remove_prefix(2)) {
      const auto byte = hex_byte(digits.substr(0, 2));
      if (!byte) return malformed(digits, "two hexadecimal digits");
      record[size++] = *byte;
      sum += *byte;
    }
    if (size < around_bytes || size != around_bytes + record[0]) {
      return malformed(row, "as many bytes as the record's length gives");
    }
    if ((sum & 0xFFU) != 0) return lines_.error_at(row, DumpCause::checksum);
    return take_record(row, std::span(record).first(size - 1));
  }

  DumpResult finish() {
    if (!ended_) return truncated("the end record :00000001FF");
    return dump_;
  }

 private:
  enum RecordType : std::uint8_t {
    data = 0,
    end_of_file = 1,
    extended_segment = 2,
    start_segment = 3,
    extended_linear = 4,
    start_linear = 5,
  };
  // Length, address, type, up to 255 bytes, checksum.
  static constexpr std::size_t around_bytes = 5;
  static constexpr std::size_t max_record_bytes = around_bytes + 255;

  std::optional<DumpError> take_record(std::string_view row, std::span<const std::uint8_t> record) {
    const std::size_t address = record[1] * std::size_t{256} + record[2];
    const std::span<const std::uint8_t> bytes = record.subspan(4);
    const auto word = [&] { return bytes[0] * std::size_t{256} + bytes[1]; };
    switch (record[3]) {
      case data:
        return put(row, base_ + address, bytes);
      case end_of_file:
        ended_ = true;
        return std::nullopt;
      case extended_segment:
      case extended_linear:
        if (bytes.size() != 2) break;
        base_ = record[3] == extended_linear ? word() << 16U : word() << 4U;
        return std::nullopt;
      case start_segment:
      case start_linear:
        return std::nullopt;
      default:
        break;
    }
    return malformed(row, "a record of type 0 to 5");
  }

  std::size_t base_ = 0;
  bool ended_ = false;
};

}  // namespace

DumpResult read_hex_page(LineSource& lines, const DumpOptions& options) {
  return HexPageReader(lines, options).read();
}

DumpResult read_hex_offsets(LineSource& lines, const DumpOptions& options) {
  return HexOffsetsReader(lines, options).read();
}

DumpResult read_intel_hex(LineSource& lines, const DumpOptions& options) {
  return IntelHexReader(lines, options).read();
}

}  // namespace biss::dump
