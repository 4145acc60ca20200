// Accesses, as `biss registers FILE --to jsonl` prints them: one object per line with the keys
// `id`, `access`, `address`, `data` and `outcome`. Reads and writes with the outcome `ok` give the
// bytes; the accesses to BSEL show which bank the registers 0x00…0x3F are in.
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <vector>

#include "biss/control/session.hpp"
#include "dump/accessed_registers.hpp"
#include "dump/readers.hpp"

namespace biss::dump {
namespace {

using Json = nlohmann::json;

// Failures of a write that no slave took.
constexpr std::array not_taken{ControlError::bad_request,   ControlError::no_answer,
                               ControlError::no_such_slave, ControlError::refused,
                               ControlError::not_addressed, ControlError::refused_or_not_addressed};

using Bytes = std::vector<std::uint8_t>;

// False if it is not a byte, or there are more bytes than registers.
bool add_byte(Bytes& bytes, std::optional<std::uint32_t> value) {
  if (value.value_or(UINT32_MAX) > 0xFF || bytes.size() > last_address) return false;
  bytes.push_back(static_cast<std::uint8_t>(*value));
  return true;
}

std::optional<std::uint32_t> number_of(const Json& value) {
  if (value.is_number_unsigned()) {
    const auto number = value.get<std::uint64_t>();
    return number <= 0xFFFF ? std::optional(static_cast<std::uint32_t>(number)) : std::nullopt;
  }
  if (!value.is_string()) return std::nullopt;
  return any_number(value.get_ref<const std::string&>());
}

// "48 44", "0x4844": pairs of digits.
bool add_pairs(Bytes& bytes, std::string_view text) {
  if (text.starts_with("0x") || text.starts_with("0X")) text.remove_prefix(2);
  for (auto word = next_word(text); !word.empty(); word = next_word(text)) {
    if (word.size() % 2 != 0) return false;
    for (std::size_t i = 0; i < word.size(); i += 2) {
      if (!add_byte(bytes, hex_byte(word.substr(i, 2)))) return false;
    }
  }
  return true;
}

std::optional<Bytes> bytes_of(const Json& value) {
  Bytes bytes;
  if (value.is_array()) {
    for (const Json& each : value) {
      if (!add_byte(bytes, number_of(each))) return std::nullopt;
    }
  } else if (value.is_string()) {
    if (!add_pairs(bytes, value.get_ref<const std::string&>())) return std::nullopt;
  } else if (!add_byte(bytes, value.is_number_unsigned() ? number_of(value) : std::nullopt)) {
    return std::nullopt;
  }
  return bytes;
}

class JsonLinesReader {
 public:
  JsonLinesReader(LineSource& lines, const DumpOptions& options)
      : lines_(lines),
        slave_(options.slave),
        slave_named_(options.slave.has_value()),
        registers_(options.bank) {}

  DumpResult read() {
    while (lines_.next()) {
      const std::string_view row = trimmed(lines_.line());
      if (row.empty()) continue;
      const Json object = Json::parse(row.begin(), row.end(), nullptr, false);
      if (!object.is_object()) return tl::unexpected(malformed(row, "a JSON object"));
      if (const auto error = take(row, object)) return tl::unexpected(*error);
    }
    if (lines_.error()) return tl::unexpected(*lines_.error());
    if (!any_) return tl::unexpected(DumpError{DumpCause::nothing_read});
    return registers_.dump();
  }

 private:
  DumpError malformed(std::string_view row, const char* expected) const {
    return lines_.error_at(row, DumpCause::malformed, expected);
  }

  static std::string_view text(const Json& object, const char* key) {
    const auto found = object.find(key);
    if (found == object.end() || !found->is_string()) return {};
    return found->get_ref<const std::string&>();
  }

  std::optional<DumpError> take(std::string_view row, const Json& object) {
    const std::string_view access = text(object, "access");
    if (access == "command") return std::nullopt;
    const bool may_write = access == "write" || access == "unknown";
    if (access != "read" && !may_write) {
      return malformed(row, "access: \"read\", \"write\", \"command\" or \"unknown\"");
    }
    const std::string_view outcome = text(object, "outcome");
    const auto address = number_of(object.value("address", Json()));
    const auto id = number_of(object.value("id", Json()));
    // The header of the access was damaged.
    if (access == "unknown" && (!id || !address)) return std::nullopt;
    if (outcome.empty() || !id) return malformed(row, "id and outcome");
    if (!address || *address > last_address) return malformed(row, "an address up to 127");
    if (slave_named_ && *id != slave_) return std::nullopt;
    if (outcome != "ok" || access == "unknown") {
      if (may_write && !certainly_not_taken(outcome)) {
        registers_.take_uncertain_write(*address);
      }
      return std::nullopt;
    }
    const auto bytes = bytes_of(object.value("data", Json()));
    if (!bytes) return malformed(row, "data: bytes as hexadecimal digits");
    if (*address + bytes->size() > last_address + 1U) {
      return lines_.error_at(row, DumpCause::outside);
    }
    if (!slave_) slave_ = static_cast<std::uint8_t>(*id & 0xFFU);
    if (*id != slave_) return lines_.error_at(row, DumpCause::several_slaves, "accesses to one ID");
    for (std::size_t i = 0; i < bytes->size(); ++i) {
      registers_.take(access == "write" ? Access::written : Access::read,
                      *address + static_cast<unsigned>(i), (*bytes)[i]);
      any_ = true;
    }
    return std::nullopt;
  }

  static bool certainly_not_taken(std::string_view outcome) {
    return std::any_of(not_taken.begin(), not_taken.end(),
                       [outcome](ControlError error) { return name_of(error) == outcome; });
  }

  LineSource& lines_;
  std::optional<std::uint32_t> slave_;
  bool slave_named_;
  AccessedRegisters registers_;
  bool any_ = false;
};

}  // namespace

DumpResult read_json_lines(LineSource& lines, const DumpOptions& options) {
  return JsonLinesReader(lines, options).read();
}

}  // namespace biss::dump
