#include "dump/readers.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "biss/control/session.hpp"
#include "dump/accessed_registers.hpp"

namespace biss::dump {
namespace {

// ---- The formats that write bytes as hexadecimal digits. `#` begins a comment in each of them.

class HexReader {
 public:
  HexReader(LineSource& lines, const DumpOptions& options) : lines_(lines), options_(options) {}

 protected:
  [[noreturn]] void fail(std::string_view place, DumpCause cause,
                         const char* expected = nullptr) const {
    throw lines_.error_at(place, cause, expected);
  }
  void require(bool good, std::string_view place, const char* expected) const {
    if (!good) fail(place, DumpCause::malformed, expected);
  }
  [[noreturn]] void fail_at_end(const char* expected) const {
    throw DumpError{DumpCause::truncated, lines_.number(), 0, expected, std::nullopt};
  }
  // Sets a byte that is empty or has this value already.
  void put(std::string_view place, std::optional<std::uint8_t>& at, std::uint8_t byte) const {
    if (at && *at != byte) fail(place, DumpCause::contradiction);
    at = byte;
  }
  // Sets bytes from an offset on.
  void put(std::string_view row, std::size_t offset, std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) {
      auto* const at = byte_at_offset(dump_, offset++, options_);
      if (at == nullptr) fail(row, DumpCause::outside);
      put(row, *at, byte);
    }
  }

  LineSource& lines_;
  const DumpOptions& options_;
  RegisterDump dump_;
};

// Registers by address, as people write them:
//
//     bank 2                      # the registers 0x00…0x3F that follow are in this bank
//     0x00: 01 02 -- xN           # a byte, a missing one, the last one N times in all
//     0x40: 02 01 62 1E
class HexPageReader : HexReader {
 public:
  using HexReader::HexReader;

  RegisterDump read() {
    for (auto row = lines_.next_row(); !row.empty(); row = lines_.next_row()) take(row);
    // The bank of registers without a heading is known only now.
    const unsigned bank = options_.bank.value_or(dump_.direct_byte(reg::bsel).value_or(0));
    for (unsigned i = 0; i < window_.size(); ++i) {
      if (!window_[i]) continue;
      auto& at = dump_.at(bank, i);
      if (at && at != window_[i]) throw DumpError{DumpCause::contradiction};
      at = window_[i];
    }
    return dump_;
  }

 private:
  void take(std::string_view row) {
    std::string_view rest = row;
    if (next_word(rest) == "bank") return take_heading(rest);
    const std::size_t colon = std::min(row.find(':'), row.size());
    const auto address = prefixed_hex_number(row.substr(0, colon));
    require(colon != row.size() && address, row, "'0x00: 48 44 --' or 'bank 2'");
    if (*address > last_address) fail(row, DumpCause::outside, "an address up to 0x7F");
    take_bytes(*address, row.substr(colon + 1));
  }

  void take_heading(std::string_view rest) {
    std::string_view word = next_word(rest);
    if (word.ends_with(':')) word.remove_suffix(1);
    bank_ = any_number(word);
    require(bank_.value_or(bank_count) < bank_count && trimmed(rest).empty(), word,
            "the number of a bank, 0 to 255");
  }

  void take_bytes(unsigned address, std::string_view rest) {
    constexpr const char* expected = "two hexadecimal digits, -- or x and a count";
    std::optional<std::uint8_t> last;
    bool first = true;
    for (std::string_view word = next_word(rest); !word.empty(); word = next_word(rest)) {
      std::uint32_t times = 1;
      if (word.starts_with('x') && !first) {
        const std::uint32_t count = any_number(word.substr(1)).value_or(0);
        require(count != 0, word, expected);
        times = std::min(count, last_address + 2U) - 1;
      } else {
        last = hex_byte(word);
        require(last || word == "--", word, expected);
      }
      first = false;
      for (; times != 0; --times, ++address) {
        if (address > last_address) fail(word, DumpCause::outside, "addresses up to 0x7F");
        const bool in_window = address < first_direct && !bank_;
        auto& at = in_window ? window_[address] : dump_.at(bank_.value_or(0), address);
        if (last) put(word, at, *last);
      }
    }
  }

  DumpedBytes window_{};  // registers 0x00…0x3F before any heading
  std::optional<unsigned> bank_;
};

// A binary as xxd and hexdump -C print it:
//
//     00000040: 0102 0000 6400 …  ....d...          xxd
//     00000040  01 02 00 00 64 00 …  |....d...|     hexdump -C
//     *                                             the last line repeated, up to the next offset
class HexOffsetsReader : HexReader {
 public:
  using HexReader::HexReader;

  RegisterDump read() {
    for (auto row = lines_.next_row(); !row.empty(); row = lines_.next_row()) take(row);
    if (repeating_) fail_at_end("an offset after the *");
    return dump_;
  }

 private:
  // xxd -c 256 is the widest there is.
  static constexpr std::size_t max_row_bytes = 256;

  void take(std::string_view row) {
    if (row == "*") {
      require(!bytes_.empty(), row, "bytes before they are repeated");
      repeating_ = true;
      return;
    }
    const std::size_t digits = hex_digits_at_front(row);
    const auto offset = hex_number(row.substr(0, digits));
    const bool ended = digits == row.size() || row[digits] == ':' || is_blank(row[digits]);
    require(digits >= 4 && offset && ended, row, "an offset of 4 to 8 hexadecimal digits");
    if (repeating_) repeat_up_to(*offset, row);
    const bool xxd = digits < row.size() && row[digits] == ':';
    take_words(
        xxd ? bytes_of_xxd(row.substr(digits + 1)) : row.substr(digits, row.find('|') - digits),
        xxd);
    next_ = *offset;
    put_row(row);
  }

  // xxd prints groups of any size up to two blanks, after which the characters follow.
  static std::string_view bytes_of_xxd(std::string_view rest) {
    rest.remove_prefix(std::min(rest.find_first_not_of(blanks), rest.size()));
    return rest.substr(0, rest.find("  "));
  }

  void take_words(std::string_view rest, bool groups) {
    bytes_.clear();
    for (auto word = next_word(rest); !word.empty(); word = next_word(rest)) {
      require(groups ? word.size() % 2 == 0 : word.size() == 2, word,
              groups ? "groups of an even number of digits"
                     : "single bytes, as hexdump -C prints them");
      for (; !word.empty(); word.remove_prefix(2)) {
        const std::string_view digits = word.substr(0, 2);
        const auto byte = hex_byte(digits);
        require(byte && bytes_.size() < max_row_bytes, digits, "two hexadecimal digits");
        bytes_.push_back(*byte);
      }
    }
  }

  void put_row(std::string_view row) {
    put(row, next_, bytes_);
    next_ += bytes_.size();
  }

  void repeat_up_to(std::size_t offset, std::string_view row) {
    repeating_ = false;
    require(offset >= next_ && (offset - next_) % bytes_.size() == 0, row,
            "an offset that is larger by a whole number of lines");
    while (next_ < offset) put_row(row);
  }

  std::vector<std::uint8_t> bytes_;  // of the last line
  std::size_t next_ = 0;             // the offset after it
  bool repeating_ = false;
};

// Intel HEX. The offset is the register's place: bank b begins at 64 b, the registers 0x40…0x7F at
// 0x4000.
class IntelHexReader : HexReader {
 public:
  using HexReader::HexReader;

  RegisterDump read() {
    for (auto row = lines_.next_row(); !row.empty(); row = lines_.next_row()) take(row);
    if (!ended_) fail_at_end("the end record :00000001FF");
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

  void take(std::string_view row) {
    require(!ended_, row, "nothing after the end record");
    require(row.front() == ':', row, "a record that begins with a colon");
    std::string_view digits = row.substr(1);
    require(digits.size() % 2 == 0 && digits.size() / 2 <= max_record_bytes, row,
            "pairs of digits, at most 260 of them");
    std::vector<std::uint8_t> record;
    unsigned sum = 0;
    for (; !digits.empty(); digits.remove_prefix(2)) {
      const auto byte = hex_byte(digits.substr(0, 2));
      require(byte.has_value(), digits, "two hexadecimal digits");
      record.push_back(*byte);
      sum += *byte;
    }
    require(record.size() >= around_bytes && record.size() == around_bytes + record[0], row,
            "as many bytes as the record's length gives");
    if ((sum & 0xFFU) != 0) fail(row, DumpCause::checksum);
    take_record(row, std::span(record).first(record.size() - 1));
  }

  void take_record(std::string_view row, std::span<const std::uint8_t> record) {
    const std::size_t address = record[1] * std::size_t{256} + record[2];
    const unsigned type = record[3];
    const std::span<const std::uint8_t> bytes = record.subspan(4);
    const bool extended = type == extended_segment || type == extended_linear;
    require(type <= start_linear && (!extended || bytes.size() == 2), row,
            "a record of type 0 to 5");
    if (type == data) put(row, base_ + address, bytes);
    if (type == end_of_file) ended_ = true;
    if (extended) {
      const std::size_t word = bytes[0] * std::size_t{256} + bytes[1];
      base_ = word << (type == extended_linear ? 16U : 4U);
    }
  }

  std::size_t base_ = 0;
  bool ended_ = false;
};

// ---- Accesses, as `biss registers FILE --to jsonl` prints them: one object per line with the keys
// `id`, `access`, `address`, `data` and `outcome`. Reads and writes with the outcome `ok` give the
// bytes; the accesses to BSEL show which bank the registers 0x00…0x3F are in.

using Json = nlohmann::json;

// Failures of a write that no slave took.
constexpr std::array not_taken{ControlError::bad_request,   ControlError::no_answer,
                               ControlError::no_such_slave, ControlError::refused,
                               ControlError::not_addressed, ControlError::refused_or_not_addressed};

std::optional<std::uint32_t> number_of(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    return number <= 0xFFFF ? std::optional(static_cast<std::uint32_t>(number)) : std::nullopt;
  }
  if (!value.is_string()) return std::nullopt;
  return any_number(value.get_ref<const std::string&>());
}

class JsonLinesReader {
 public:
  JsonLinesReader(LineSource& lines, const DumpOptions& options)
      : lines_(lines),
        slave_(options.slave),
        slave_named_(options.slave.has_value()),
        registers_(options.bank) {}

  RegisterDump read() {
    while (lines_.next()) {
      row_ = trimmed(lines_.line());
      if (!row_.empty()) take(Json::parse(row_.begin(), row_.end(), nullptr, false));
    }
    if (lines_.error()) throw *lines_.error();
    if (!any_) throw DumpError{DumpCause::nothing_read};
    return registers_.dump();
  }

 private:
  void require(bool good, const char* expected, DumpCause cause = DumpCause::malformed) const {
    if (!good) throw lines_.error_at(row_, cause, expected);
  }

  static std::string_view text(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_string()) return {};
    return found->get_ref<const std::string&>();
  }

  void take(const Json& object) {
    require(object.is_object(), "a JSON object");
    const std::string_view access = text(object, "access");
    if (access == "command") return;
    const bool may_write = access == "write" || access == "unknown";
    require(access == "read" || may_write,
            "access: \"read\", \"write\", \"command\" or \"unknown\"");
    const std::string_view outcome = text(object, "outcome");
    const auto address = number_of(object.value("address", Json()));
    const auto id = number_of(object.value("id", Json()));
    // The header of the access was damaged.
    if (access == "unknown" && (!id || !address)) return;
    require(!outcome.empty() && id, "id and outcome");
    require(address && *address <= last_address, "an address up to 127");
    if (slave_named_ && *id != slave_) return;
    if (outcome != "ok" || access == "unknown") {
      if (may_write && !certainly_not_taken(outcome)) registers_.take_uncertain_write(*address);
      return;
    }
    const std::vector<std::uint8_t> bytes = bytes_of(object.value("data", Json()));
    require(*address + bytes.size() <= last_address + 1U, nullptr, DumpCause::outside);
    if (!slave_) slave_ = static_cast<std::uint8_t>(*id & 0xFFU);
    require(*id == slave_, "accesses to one ID", DumpCause::several_slaves);
    unsigned next = *address;
    for (const std::uint8_t byte : bytes) {
      registers_.take(access == "write" ? Access::written : Access::read, next++, byte);
      any_ = true;
    }
  }

  std::vector<std::uint8_t> bytes_of(const Json& value) const {
    std::vector<std::uint8_t> bytes;
    const auto add = [&](std::optional<std::uint32_t> byte) {
      require(byte && *byte <= 0xFF && bytes.size() <= last_address,
              "data: bytes as hexadecimal digits");
      bytes.push_back(static_cast<std::uint8_t>(*byte));
    };
    if (value.is_array()) {
      for (const Json& each : value) add(number_of(each));
    } else if (value.is_string()) {
      // Pairs of digits: "48 44", "0x4844".
      std::string_view text = value.get_ref<const std::string&>();
      if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
      for (auto word = next_word(text); !word.empty(); word = next_word(text)) {
        for (std::size_t i = 0; i < word.size(); i += 2) add(hex_byte(word.substr(i, 2)));
      }
    } else {
      add(value.is_number_unsigned() ? number_of(value) : std::nullopt);
    }
    return bytes;
  }

  static bool certainly_not_taken(std::string_view outcome) {
    return std::any_of(not_taken.begin(), not_taken.end(),
                       [outcome](ControlError error) { return name_of(error) == outcome; });
  }

  LineSource& lines_;
  std::string_view row_;
  std::optional<std::uint32_t> slave_;
  bool slave_named_;
  AccessedRegisters registers_;
  bool any_ = false;
};

}  // namespace

RegisterDump read_text(DumpFormat format, LineSource& lines, const DumpOptions& options) {
  switch (format) {
    case DumpFormat::hex_page:
      return HexPageReader(lines, options).read();
    case DumpFormat::hex_offsets:
      return HexOffsetsReader(lines, options).read();
    case DumpFormat::intel_hex:
      return IntelHexReader(lines, options).read();
    default:
      return JsonLinesReader(lines, options).read();
  }
}

}  // namespace biss::dump
