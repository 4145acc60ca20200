// Intel HEX. A register's address is its offset: bank b from 64 b on, the registers 0x40…0x7F from
// 0x4000 on.
#include <array>
#include <span>

#include "dump/hex_digits.hpp"
#include "dump/place.hpp"
#include "dump/read.hpp"

namespace biss::dump {
namespace {

enum RecordType : std::uint8_t {
  data = 0,
  end_of_file = 1,
  extended_segment = 2,
  start_segment = 3,
  extended_linear = 4,
  start_linear = 5,
};

// Length, address, type, up to 255 bytes, checksum.
constexpr std::size_t around_bytes = 5;
constexpr std::size_t max_record_bytes = around_bytes + 255;

class IntelHexReader {
 public:
  IntelHexReader(LineSource& lines, const DumpOptions& options)
      : lines_(lines), options_(options) {}

  DumpResult read() {
    while (lines_.next()) {
      const std::string_view row = trimmed(lines_.line());
      if (row.empty() || row.front() == '#') continue;
      if (ended_) return fail(row, DumpCause::malformed, "nothing behind the end record");
      if (const auto error = take(row)) return failure(*error);
    }
    if (lines_.error()) return failure(*lines_.error());
    if (!ended_) {
      return failure(
          DumpError{DumpCause::truncated, lines_.number(), 0, "the end record :00000001FF"});
    }
    return dump_;
  }

 private:
  Failure<DumpError> fail(std::string_view place, DumpCause cause, const char* expected) const {
    return failure(lines_.error_at(place, cause, expected));
  }

  std::optional<DumpError> take(std::string_view row) {
    const auto bad = [&](std::string_view place, const char* expected) {
      return lines_.error_at(place, DumpCause::malformed, expected);
    };
    if (row.front() != ':') return bad(row, "a record that begins with a colon");
    std::string_view digits = row.substr(1);
    if (digits.size() % 2 != 0 || digits.size() / 2 > max_record_bytes) {
      return bad(row, "pairs of digits, at most 260 of them");
    }
    std::array<std::uint8_t, max_record_bytes> record{};
    std::size_t size = 0;
    unsigned sum = 0;
    for (; !digits.empty(); digits.remove_prefix(2)) {
      const auto byte = hex_number(digits.substr(0, 2));
      if (!byte) return bad(digits, "two hexadecimal digits");
      record[size++] = static_cast<std::uint8_t>(*byte);
      sum += *byte;
    }
    if (size < around_bytes || size != around_bytes + record[0]) {
      return bad(row, "as many bytes as the record's length says");
    }
    if ((sum & 0xFFU) != 0) return lines_.error_at(row, DumpCause::checksum);
    return take_record(row, std::span(record).first(size - 1));
  }

  std::optional<DumpError> take_record(std::string_view row, std::span<const std::uint8_t> record) {
    const std::size_t address = record[1] * std::size_t{256} + record[2];
    const std::span<const std::uint8_t> bytes = record.subspan(4);
    const auto word = [&] { return bytes[0] * std::size_t{256} + bytes[1]; };
    switch (record[3]) {
      case data:
        return take_data(row, address, bytes);
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
    return lines_.error_at(row, DumpCause::malformed, "a record of type 0 to 5");
  }

  std::optional<DumpError> take_data(std::string_view row, std::size_t address,
                                     std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      if (const auto cause = place_at_offset(dump_, base_ + address++, byte, options_)) {
        return lines_.error_at(row, *cause);
      }
    }
    return std::nullopt;
  }

  LineSource& lines_;
  const DumpOptions& options_;
  RegisterDump dump_;
  std::size_t base_ = 0;
  bool ended_ = false;
};

}  // namespace

DumpResult read_intel_hex(LineSource& lines, const DumpOptions& options) {
  return IntelHexReader(lines, options).read();
}

}  // namespace biss::dump
