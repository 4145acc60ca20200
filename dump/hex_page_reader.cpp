// Registers by address, as people write them down:
//
//     bank 2                      # the registers 0x00…0x3F that follow are of this bank
//     0x00: 01 02 -- xN           # a byte, none, the last one N times in all
//     0x40: 02 01 62 1E
#include <algorithm>

#include "dump/hex_digits.hpp"
#include "dump/place.hpp"
#include "dump/read.hpp"

namespace biss::dump {
namespace {

constexpr const char* expected_row = "'0x00: 48 44 --' or 'bank 2'";
constexpr const char* expected_byte = "two hexadecimal digits, -- or x and a count";

class HexPageReader {
 public:
  HexPageReader(LineSource& lines, const DumpOptions& options) : lines_(lines), options_(options) {}

  DumpResult read() {
    bool any = false;
    while (lines_.next()) {
      const std::string_view line = lines_.line();
      std::string_view row = trimmed(line.substr(0, line.find('#')));
      if (row.empty()) continue;
      any = true;
      if (const auto error = take(row)) return failure(*error);
    }
    if (lines_.error()) return failure(*lines_.error());
    if (!any) return failure(DumpError{DumpCause::empty});
    return settled();
  }

 private:
  std::optional<DumpError> take(std::string_view row) {
    std::string_view rest = row;
    const std::string_view word = next_word(rest);
    if (word == "bank") return take_heading(rest);
    const std::size_t colon = row.find(':');
    const std::string_view digits = row.substr(0, std::min(colon, row.size()));
    const auto address = digits.starts_with("0x") || digits.starts_with("0X")
                             ? hex_number(digits.substr(2))
                             : std::nullopt;
    if (colon == std::string_view::npos || !address) {
      return lines_.error_at(row, DumpCause::malformed, expected_row);
    }
    if (*address > last_address) {
      return lines_.error_at(row, DumpCause::outside, "an address up to 0x7F");
    }
    return take_bytes(*address, row.substr(colon + 1));
  }

  std::optional<DumpError> take_heading(std::string_view rest) {
    std::string_view word = next_word(rest);
    if (word.ends_with(':')) word.remove_suffix(1);
    const auto number = any_number(word);
    if (!number || *number >= bank_count || !trimmed(rest).empty()) {
      return lines_.error_at(word, DumpCause::malformed, "the number of a bank, 0 to 255");
    }
    bank_ = *number;
    return std::nullopt;
  }

  std::optional<DumpError> take_bytes(unsigned address, std::string_view rest) {
    std::optional<std::uint8_t> last;
    bool first = true;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      std::uint32_t times = 1;
      if (word.starts_with('x') && !first) {
        const auto count = any_number(word.substr(1));
        if (!count || *count == 0) {
          return lines_.error_at(word, DumpCause::malformed, expected_byte);
        }
        times = std::min(*count, last_address + 2U) - 1;
      } else if (word == "--") {
        last = std::nullopt;
      } else if (const auto byte = hex_number(word); byte && word.size() == 2) {
        last = static_cast<std::uint8_t>(*byte);
      } else {
        return lines_.error_at(word, DumpCause::malformed, expected_byte);
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
    // Whose bank an unheaded window is may only be known at the end.
    auto& at =
        address < first_direct && !bank_ ? window_[address] : dump_.at(bank_.value_or(0), address);
    // There is one; GCC 12 at -O3 does not see that of *byte.
    return place(at, byte.value_or(0));
  }

  DumpResult settled() {
    const unsigned bank = options_.bank.value_or(dump_.direct_byte(reg::bsel).value_or(0));
    for (unsigned i = 0; i < window_.size(); ++i) {
      if (!window_[i]) continue;
      if (const auto cause = place(dump_.at(bank, i), *window_[i])) {
        return failure(DumpError{*cause});
      }
    }
    return dump_;
  }

  LineSource& lines_;
  const DumpOptions& options_;
  RegisterDump dump_;
  DumpedBytes window_{};  // registers 0x00…0x3F before any heading
  std::optional<unsigned> bank_;
};

}  // namespace

DumpResult read_hex_page(LineSource& lines, const DumpOptions& options) {
  return HexPageReader(lines, options).read();
}

}  // namespace biss::dump
