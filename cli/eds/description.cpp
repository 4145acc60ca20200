#include "cli/eds/description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "biss/eds/image.hpp"
#include "cli/common/verb.hpp"
#include "cli/eds/derive.hpp"
#include "cli/eds/value.hpp"
#include "dump/hex_digits.hpp"
#include "dump/line_source.hpp"

namespace biss::cli {
namespace {

enum class SectionKind : std::uint8_t { registers, common, bp3, bank };

constexpr std::array<std::string_view, 4> section_names{"registers", "common", "bp3", "bank"};

struct Section {
  SectionKind kind{};
  unsigned number = 0;  // channel or bank
  auto operator<=>(const Section&) const = default;
};

struct Assignment {
  std::string symbol;
  std::string value;
  std::uint64_t line = 0;
};

std::string_view without_comment(std::string_view line) {
  return dump::trimmed(line.substr(0, line.find('#')));
}

// `bp3 1` between the brackets.
std::optional<Section> section_of(std::string_view inside) {
  std::string_view rest = inside;
  const std::string_view name = dump::next_word(rest);
  const auto* const found = std::find(section_names.begin(), section_names.end(), name);
  if (found == section_names.end()) return std::nullopt;
  Section section{static_cast<SectionKind>(found - section_names.begin()), 0};
  const std::string_view digits = dump::trimmed(rest);
  const bool may = section.kind == SectionKind::bp3 || section.kind == SectionKind::bank;
  if (digits.empty()) {
    return section.kind == SectionKind::bank ? std::nullopt : std::optional(section);
  }
  const auto number = dump::any_number(digits);
  const std::size_t end = section.kind == SectionKind::bp3 ? max_channels : bank_count;
  if (!may || !number || *number >= end) return std::nullopt;
  section.number = *number;
  return section;
}

class DescriptionReader {
 public:
  explicit DescriptionReader(dump::LineSource& lines) : lines_(lines) {}

  DescribedDump read() {
    DescribedDump result;
    result.error = read_lines();
    for (const auto& [section, assignments] : sections_) {
      if (result.error.empty()) result.error = take_section(section, assignments);
    }
    if (result.error.empty()) result.error = fill_in(parts_);
    result.dump = parts_.dump;
    return result;
  }

 private:
  using Assignments = std::vector<Assignment>;

  static std::string at(std::uint64_t line, std::string_view what) {
    return fmt::format("line {}: {}", line, what);
  }

  std::string read_lines() {
    std::optional<Section> section;
    while (lines_.next()) {
      const std::string_view row = without_comment(lines_.line());
      if (row.empty()) continue;
      if (row.front() == '[') {
        section = row.back() == ']' ? section_of(row.substr(1, row.size() - 2)) : std::nullopt;
        if (!section) {
          return at(lines_.number(),
                    "a section is [registers], [common], [bp3], [bp3 1] to [bp3 7] or [bank 0] to "
                    "[bank 255]");
        }
        sections_[*section];
        continue;
      }
      const std::size_t sign = row.find('=');
      if (sign == std::string_view::npos) return at(lines_.number(), "expected SYMBOL = value");
      if (!section) return at(lines_.number(), "expected a section such as [common] first");
      const std::string symbol(dump::trimmed(row.substr(0, sign)));
      const std::string value(dump::trimmed(row.substr(sign + 1)));
      if (symbol.empty()) return at(lines_.number(), "expected SYMBOL = value");
      if (value.empty()) return at(lines_.number(), fmt::format("{} has no value", symbol));
      for (const Assignment& before : sections_[*section]) {
        if (before.symbol != symbol) continue;
        return at(lines_.number(), fmt::format("{} was given in line {}", symbol, before.line));
      }
      sections_[*section].push_back({symbol, value, lines_.number()});
    }
    return lines_.error() ? dump::dump_error_text(*lines_.error()) : std::string();
  }

  std::string take_section(const Section& section, const Assignments& assignments) {
    switch (section.kind) {
      case SectionKind::common:
        parts_.common.emplace();
        return take_fields(*parts_.common, common_fields, assignments);
      case SectionKind::bp3:
        parts_.profiles[section.number].emplace();
        return take_fields(*parts_.profiles[section.number], bp3_fields, assignments);
      case SectionKind::registers:
        return take_registers(assignments);
      case SectionKind::bank:
        break;
    }
    for (const Assignment& each : assignments) {
      std::string error = take_bytes(each, section.number, 0, dump::first_direct);
      if (!error.empty()) return error;
    }
    return {};
  }

  static std::string take_fields(PartInWork& part, std::span<const EdsField> fields,
                                 const Assignments& assignments) {
    const bool linear =
        std::any_of(assignments.begin(), assignments.end(), [](const Assignment& each) {
          return each.symbol == "EN_TYP" && (each.value == "linear" || each.value == "1");
        });
    for (const Assignment& each : assignments) {
      const EdsField* field = find_field(fields, each.symbol);
      if (field == nullptr) return at(each.line, unknown(each.symbol, fields));
      const EdsValue value = parse_eds_value(*field, each.value, linear);
      if (!value.error.empty()) {
        return at(each.line, fmt::format("{} = {}: {}", each.symbol, each.value, value.error));
      }
      part.set(*field, value.value);
    }
    return {};
  }

  static std::string unknown(const std::string& symbol, std::span<const EdsField> fields) {
    std::vector<std::string> symbols;
    for (const EdsField& field : fields) symbols.emplace_back(field.symbol);
    const std::string meant = nearest(symbol, symbols);
    return meant.empty() ? fmt::format("this part has no '{}'", symbol)
                         : fmt::format("this part has no '{}'; did you mean {}?", symbol, meant);
  }

  std::string take_registers(const Assignments& assignments) {
    for (const Assignment& each : assignments) {
      std::string error;
      const auto* const field =
          std::find_if(register_fields.begin(), register_fields.end(),
                       [&](const RegisterField& known) { return known.name == each.symbol; });
      const bool number = field != register_fields.end() && field->bytes <= 6;
      error = number ? take_number(each, *field)
                     : take_bytes(each, 0, dump::first_direct, dump::last_address + 1U);
      if (!error.empty()) return error;
    }
    return {};
  }

  std::string take_number(const Assignment& each, const RegisterField& field) {
    const auto value = parse_count(each.value, low_mask(8U * field.bytes));
    if (!value.ok()) {
      return at(each.line, fmt::format("{} = {}: a number of at most {} bytes", each.symbol,
                                       each.value, field.bytes));
    }
    for (unsigned i = 0; i < field.bytes; ++i) {
      const auto byte = static_cast<std::uint8_t>(*value >> (8U * (field.bytes - 1U - i)));
      std::string error = put(each, 0, field.address + i, byte);
      if (!error.empty()) return error;
    }
    return {};
  }

  // `0x48 = 00 01 FF`
  std::string take_bytes(const Assignment& each, unsigned bank, unsigned first, unsigned end) {
    const bool hexadecimal = each.symbol.starts_with("0x");
    const auto address =
        hexadecimal ? dump::hex_number(std::string_view(each.symbol).substr(2)) : std::nullopt;
    if (!address || *address < first || *address >= end) {
      return at(each.line,
                fmt::format("'{}' is no register here: 0x{:02X} to 0x{:02X}{}", each.symbol, first,
                            end - 1, first == 0 ? "" : ", or EDS_BANK, BP_ID, DEV_SN, MFR_ID"));
    }
    unsigned place = *address;
    std::string_view rest = each.value;
    for (auto word = dump::next_word(rest); !word.empty(); word = dump::next_word(rest), ++place) {
      const auto byte = dump::hex_number(word);
      if (word == "--" && place < end) continue;
      if (!byte || word.size() != 2 || place >= end) {
        return at(each.line, place >= end ? fmt::format("bytes beyond 0x{:02X}", end - 1)
                                          : fmt::format("'{}': expected bytes as 00 1A FF", word));
      }
      std::string error = put(each, bank, place, static_cast<std::uint8_t>(*byte));
      if (!error.empty()) return error;
    }
    return {};
  }

  std::string put(const Assignment& each, unsigned bank, unsigned address, std::uint8_t byte) {
    auto& place = parts_.dump.at(bank, address);
    if (place && *place != byte) {
      return at(each.line,
                fmt::format("register 0x{:02X} was given another value before", address));
    }
    place = byte;
    return {};
  }

  dump::LineSource& lines_;
  std::map<Section, Assignments> sections_;
  PartsInWork parts_;
};

}  // namespace

bool looks_like_description(std::string_view head) {
  if (head.starts_with("\xEF\xBB\xBF")) head.remove_prefix(3);
  while (!head.empty()) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    const std::string_view row = without_comment(head.substr(0, end));
    if (!row.empty()) {
      return row.size() > 1 && row.front() == '[' && row[1] >= 'a' && row[1] <= 'z';
    }
    head.remove_prefix(std::min(end + 1, head.size()));
  }
  return false;
}

DescribedDump read_description(std::istream& stream, std::string head) {
  dump::LineSource lines(stream, std::move(head));
  return DescriptionReader(lines).read();
}

}  // namespace biss::cli
