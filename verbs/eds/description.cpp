#include "verbs/eds/description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "biss/control/register_map.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/image.hpp"
#include "device/nearest.hpp"
#include "dump/text.hpp"
#include "dump/write.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/eds/draft.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/value.hpp"

namespace biss::verbs {
namespace {

using dump::any_number;
using dump::next_word;
using dump::trimmed;

// Registers longer than this are bytes, not a number.
constexpr unsigned max_number_bytes = 6;

enum class SectionKind : std::uint8_t { registers, common, bp3, bank };

// A section may have a number below `numbers`: `bp3 1`.
struct SectionName {
  std::string_view name;
  unsigned numbers;
};
constexpr auto section_names = std::to_array<SectionName>(
    {{"registers", 0}, {"common", 0}, {"bp3", max_channels}, {"bank", bank_count}});

struct Section {
  SectionKind kind{};
  unsigned number = 0;  // channel or bank
  auto operator<=>(const Section&) const = default;
};

struct Assignment {
  std::string symbol;
  std::string value;
  std::uint64_t line = 0;

  template <class... Arguments>
  [[noreturn]] void fail(fmt::format_string<Arguments...> text, Arguments&&... arguments) const {
    throw std::runtime_error(fmt::format("line {}: ", line) +
                             fmt::format(text, std::forward<Arguments>(arguments)...));
  }
};

// `bp3 1` between the brackets.
std::optional<Section> section_of(std::string_view inside) {
  const std::string_view name = next_word(inside);
  const auto* const found =
      std::find_if(section_names.begin(), section_names.end(),
                   [&](const SectionName& section) { return section.name == name; });
  if (found == section_names.end()) return std::nullopt;
  const auto kind = static_cast<SectionKind>(found - section_names.begin());
  const std::string_view digits = trimmed(inside);
  if (digits.empty() && kind != SectionKind::bank) return Section{kind};
  const auto number = any_number(digits);
  return number && *number < found->numbers ? std::optional(Section{kind, *number}) : std::nullopt;
}

// The registers that are given by name.
std::string register_names() {
  std::string out;
  for (const RegisterField& field : register_fields) {
    if (field.address < dump::first_direct || field.bytes > max_number_bytes) continue;
    out += fmt::format(", {}", field.name);
  }
  return out;
}

class DescriptionReader {
 public:
  explicit DescriptionReader(dump::LineSource& lines) : lines_(lines) {}

  Description read() {
    read_lines();
    for (const auto& [section, assignments] : sections_) take_section(section, assignments);
    place_parts();
    return {dump_, parts_};
  }

 private:
  using Assignments = std::vector<Assignment>;

  void read_lines() {
    Assignments* section = nullptr;
    for (auto row = lines_.next_row(); !row.empty(); row = lines_.next_row()) {
      const std::size_t sign = row.find('=');
      Assignment each{std::string(trimmed(row.substr(0, sign))), {}, lines_.number()};
      if (row.front() == '[') {
        const auto named =
            row.back() == ']' ? section_of(row.substr(1, row.size() - 2)) : std::nullopt;
        if (!named) {
          each.fail(
              "a section is [registers], [common], [bp3], [bp3 1] to [bp3 7] or [bank 0] to "
              "[bank 255]");
        }
        section = &sections_[*named];
        continue;
      }
      const bool has_sign = sign != std::string_view::npos;
      if (has_sign && section == nullptr) each.fail("expected a section such as [common] first");
      if (!has_sign || each.symbol.empty()) each.fail("expected SYMBOL = value");
      each.value = trimmed(row.substr(sign + 1));
      if (each.value.empty()) each.fail("{} has no value", each.symbol);
      for (const Assignment& before : *section) {
        if (before.symbol == each.symbol) {
          each.fail("{} was given in line {}", each.symbol, before.line);
        }
      }
      section->push_back(std::move(each));
    }
  }

  void take_section(const Section& section, const Assignments& assignments) {
    switch (section.kind) {
      case SectionKind::common:
        return take_fields(draft_.common.emplace(), common_fields, assignments);
      case SectionKind::bp3:
        return take_fields(draft_.profiles[section.number].emplace(), bp3_fields, assignments);
      case SectionKind::registers:
        for (const Assignment& each : assignments) take_register(each);
        return;
      case SectionKind::bank:
        for (const Assignment& each : assignments) {
          take_bytes(each, section.number, 0, dump::first_direct);
        }
    }
  }

  static void take_fields(EdsPartDraft& part, std::span<const EdsField> fields,
                          const Assignments& assignments) {
    const bool linear =
        std::any_of(assignments.begin(), assignments.end(), [](const Assignment& each) {
          return each.symbol == "EN_TYP" && (each.value == "linear" || each.value == "1");
        });
    for (const Assignment& each : assignments) {
      const EdsField* field = find_field(fields, each.symbol);
      if (field == nullptr) {
        std::vector<std::string> symbols;
        for (const EdsField& known : fields) symbols.emplace_back(known.symbol);
        const std::string meant = nearest(each.symbol, symbols);
        each.fail("this part has no '{}'{}", each.symbol,
                  meant.empty() ? meant : fmt::format("; did you mean {}?", meant));
      }
      const auto value = parse_eds_value(*field, each.value, linear);
      if (!value) each.fail("{} = {}: {}", each.symbol, each.value, value.error());
      part.give(*field, *value);
    }
  }

  void take_register(const Assignment& each) {
    const auto* const field =
        std::find_if(register_fields.begin(), register_fields.end(),
                     [&](const RegisterField& known) { return known.name == each.symbol; });
    if (field == register_fields.end() || field->bytes > max_number_bytes) {
      return take_bytes(each, 0, dump::first_direct, dump::last_address + 1U);
    }
    const auto value = parse_count(each.value, low_mask(8U * field->bytes));
    if (!value.ok()) {
      each.fail("{} = {}: a number of at most {} bytes", each.symbol, each.value, field->bytes);
    }
    for (unsigned i = 0; i < field->bytes; ++i) {
      put(each, 0, field->address + i,
          static_cast<std::uint8_t>(*value >> (8U * (field->bytes - 1U - i))));
    }
  }

  // `0x48 = 00 01 FF`
  void take_bytes(const Assignment& each, unsigned bank, unsigned first, unsigned end) {
    const auto address = dump::prefixed_hex_number(each.symbol);
    if (!address || *address < first || *address >= end) {
      each.fail("'{}' is not a register here: 0x{:02X} to 0x{:02X}{}", each.symbol, first, end - 1,
                first == 0 ? "" : register_names());
    }
    unsigned place = *address;
    std::string_view rest = each.value;
    for (auto word = next_word(rest); !word.empty(); word = next_word(rest), ++place) {
      if (place >= end) each.fail("bytes beyond 0x{:02X}", end - 1);
      if (word == "--") continue;
      const auto byte = dump::hex_byte(word);
      if (!byte) each.fail("'{}': expected bytes such as 00 1A FF", word);
      put(each, bank, place, *byte);
    }
  }

  void put(const Assignment& each, unsigned bank, unsigned address, std::uint8_t byte) {
    auto& place = dump_.at(bank, address);
    if (place && *place != byte) {
      each.fail("register 0x{:02X} was given another value before", address);
    }
    place = byte;
  }

  // Derives the fields that were left out, and puts the parts into their banks.
  void place_parts() {
    if (const auto bank = dump_.direct_byte(reg::eds_bank)) draft_.eds_bank = *bank;
    if (draft_.common && draft_.eds_bank == 0) {
      throw std::runtime_error(
          "EDS_BANK = 0 means that there is no data sheet, but there is [common]");
    }
    draft_.derive();
    if (draft_.common) {
      put_registers();
      place_part(draft_.eds_bank, *draft_.common, "[common]", parts_.common);
      parts_.eds_bank = draft_.eds_bank;
    }
    for (std::size_t i = 0; i < max_channels; ++i) {
      if (!draft_.profiles[i]) continue;
      place_part(draft_.profile_bank(i), *draft_.profiles[i], fmt::format("[bp3 {}]", i),
                 parts_.profiles[i]);
    }
    if (const auto stated = dump_.direct_number(reg::bp_id, 2); stated && *stated != 0) {
      const std::size_t own = draft_.common ? parse_common_part(draft_.common->bank).sl_off : 0U;
      if (own < max_channels) parts_.identifiers[own] = static_cast<std::uint16_t>(*stated);
    }
  }

  void place_part(unsigned bank, const EdsPartDraft& part, std::string_view name,
                  std::optional<dump::FoundPart>& placed) {
    if (dump_.known_bytes(bank) != 0) {
      throw std::runtime_error(
          fmt::format("{} belongs in bank {}, which is given otherwise", name, bank));
    }
    dump_.set_bank(bank, part.bank);
    placed = {static_cast<std::uint8_t>(bank), dump_.bank(bank), true, part.bank};
  }

  // The registers that lead to the data sheet.
  void put_registers() {
    dump_.at(0, reg::eds_bank) = draft_.eds_bank;
    const auto identifier = draft_.identifier();
    if (!identifier || dump_.direct_byte(reg::bp_id) || dump_.direct_byte(reg::bp_id + 1)) return;
    dump_.at(0, reg::bp_id) = static_cast<std::uint8_t>(*identifier >> 8U);
    dump_.at(0, reg::bp_id + 1) = static_cast<std::uint8_t>(*identifier & 0xFFU);
  }

  dump::LineSource& lines_;
  std::map<Section, Assignments> sections_;
  EdsDraft draft_;
  dump::RegisterDump dump_;
  dump::DataSheet parts_;
};

void append_fields(std::string& out, const dump::FoundPart& part, EdsPart kind) {
  const bool linear = kind == EdsPart::bp3 && parse_bp3_part(part.filled).linear();
  for (const EdsField& field : fields_of(kind)) {
    const std::uint32_t value = field_value(part.filled, field);
    if (value == 0 && is_unused(field, kind, part.filled)) continue;
    const std::string text = eds_value_text(field, value, linear);
    const std::string given = fmt::format("{} = {}", field.symbol, text);
    std::string means = eds_meaning(field, value, linear);
    if (means == text) means.clear();
    out += fmt::format("{:<28} # {}{}{}\n", given, field.meaning, means.empty() ? "" : ": ", means);
  }
}

// Complete fields by their name, the rest byte by byte.
void append_registers(std::string& out, const dump::RegisterDump& dump,
                      std::optional<std::uint8_t> eds_bank) {
  dump::DumpedBytes rest = dump.direct();
  std::string named;
  for (const RegisterField& field : register_fields) {
    if (field.address < dump::first_direct || field.bytes > max_number_bytes) continue;
    auto value = dump.direct_number(field.address, field.bytes);
    if (field.address == reg::eds_bank && !value && eds_bank) value = *eds_bank;
    if (!value) continue;
    named += fmt::format("{} = 0x{:0{}X}\n", field.name, *value, 2 * field.bytes);
    for (unsigned i = 0; i < field.bytes; ++i) {
      rest[field.address - dump::first_direct + i] = std::nullopt;
    }
  }
  dump::append_hex_rows(named, rest, dump::first_direct, " =");
  if (!named.empty()) out += "[registers]\n" + named;
}

}  // namespace

bool looks_like_description(std::string_view head) {
  const std::string_view row = dump::first_row(head);
  return row.size() > 1 && row.front() == '[' && row[1] >= 'a' && row[1] <= 'z';
}

tl::expected<Description, std::string> read_description(std::istream& stream,
                                                        std::string head) try {
  dump::LineSource lines(stream, std::move(head));
  return DescriptionReader(lines).read();
} catch (const dump::DumpError& error) {
  return tl::unexpected(dump_error_text(error));
} catch (const std::runtime_error& error) {
  return tl::unexpected(std::string(error.what()));
}

std::string write_description(const dump::RegisterDump& dump, const dump::DataSheet& sheet) {
  std::string out;
  std::set<unsigned> written;
  append_registers(out, dump, sheet.eds_bank);
  const auto heading = [&out](std::string_view text) {
    out += fmt::format("{}[{}]\n", out.empty() ? "" : "\n", text);
  };
  // If the common part is not in the bank that register 0x41 names, its bytes are written.
  const auto stated = dump.direct_byte(reg::eds_bank);
  const bool has_common = sheet.common && sheet.common->whole && sheet.eds_bank &&
                          stated.value_or(*sheet.eds_bank) == *sheet.eds_bank;
  if (has_common) {
    heading("common");
    append_fields(out, *sheet.common, EdsPart::common);
    written.insert(sheet.common->bank);
  }
  const EdsImage image = sheet.image();
  for (std::size_t i = 0; i < max_channels; ++i) {
    const auto& part = sheet.profiles[i];
    if (!part || !part->whole || written.contains(part->bank)) continue;
    // Without common part nothing shows in which bank it is.
    if (!has_common && part->bank != i) continue;
    if (profile_part(image, i) != EdsPart::bp3) continue;
    heading(i == 0 ? "bp3" : fmt::format("bp3 {}", i));
    append_fields(out, *part, EdsPart::bp3);
    written.insert(part->bank);
  }
  for (unsigned number = 0; number < bank_count; ++number) {
    if (written.contains(number) || dump.known_bytes(number) == 0) continue;
    heading(fmt::format("bank {}", number));
    dump::append_hex_rows(out, dump.bank(number), 0, " =");
  }
  return out;
}

}  // namespace biss::verbs
