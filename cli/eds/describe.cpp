// The other way of eds_description.hpp: a dump as a description.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <vector>

#include "biss/control/register_map.hpp"
#include "biss/eds/image.hpp"
#include "cli/eds/description.hpp"
#include "cli/eds/value.hpp"

namespace biss::cli {
namespace {

using dump::FoundPart;

bool is_silent(const EdsField& field) {
  return field.kind == EdsKind::reserved || field.kind == EdsKind::unnamed;
}

// BANK_i to CPOLY_i of a channel that the device has not.
bool beyond_channels(const EdsField& field, unsigned channels) {
  return field.address >= common_channel_address(channels) &&
         field.address < common_channel_address(max_channels);
}

void append_fields(std::string& out, const FoundPart& part, EdsPart kind) {
  const bool linear = kind == EdsPart::bp3 && parse_bp3_part(part.filled).linear();
  const unsigned channels =
      kind == EdsPart::common
          ? std::min<unsigned>(parse_common_part(part.filled).dc_num, max_channels)
          : static_cast<unsigned>(max_channels);
  for (const EdsField& field : fields_of(kind)) {
    const std::uint32_t value = field_value(part.filled, field);
    const bool unused =
        is_silent(field) || (kind == EdsPart::common && beyond_channels(field, channels));
    if (unused && value == 0) continue;
    const std::string text = eds_value_text(field, value, linear);
    const std::string given = fmt::format("{} = {}", field.symbol, text);
    std::string means = eds_meaning(field, value, linear);
    if (means == text) means.clear();
    fmt::format_to(std::back_inserter(out), "{:<28} # {}{}{}\n", given, field.meaning,
                   means.empty() ? "" : ": ", means);
  }
}

void append_rows(std::string& out, const dump::DumpedBytes& bytes, unsigned first) {
  constexpr std::size_t row_bytes = 16;
  for (std::size_t i = 0; i < bytes.size(); i += row_bytes) {
    const auto row = std::span(bytes).subspan(i, row_bytes);
    if (std::none_of(row.begin(), row.end(), [](const auto& b) { return b.has_value(); })) continue;
    fmt::format_to(std::back_inserter(out), "0x{:02X} =", first + i);
    for (const auto& byte : row) out += byte ? fmt::format(" {:02X}", *byte) : " --";
    out += '\n';
  }
}

// Fields that are whole by their name, the rest byte by byte.
void append_registers(std::string& out, const dump::RegisterDump& dump,
                      std::optional<std::uint8_t> eds_bank) {
  dump::DumpedBytes rest = dump.direct();
  std::string named;
  for (const RegisterField& field : register_fields) {
    if (field.address < dump::first_direct || field.bytes > 6) continue;
    auto value = dump.direct_number(field.address, field.bytes);
    if (field.address == reg::eds_bank && !value && eds_bank) value = *eds_bank;
    if (!value) continue;
    fmt::format_to(std::back_inserter(named), "{} = 0x{:0{}X}\n", field.name, *value,
                   2 * field.bytes);
    for (unsigned i = 0; i < field.bytes; ++i) {
      rest[field.address - dump::first_direct + i] = std::nullopt;
    }
  }
  append_rows(named, rest, dump::first_direct);
  if (!named.empty()) out += "[registers]\n" + named;
}

}  // namespace

std::string write_description(const dump::RegisterDump& dump, const dump::DataSheet& sheet) {
  std::string out;
  std::vector<bool> told(bank_count, false);
  append_registers(out, dump, sheet.eds_bank);
  const auto heading = [&out](std::string_view text) {
    if (!out.empty()) out += '\n';
    fmt::format_to(std::back_inserter(out), "[{}]\n", text);
  };
  const bool has_common = sheet.common && sheet.common->whole && sheet.eds_bank;
  if (has_common) {
    heading("common");
    append_fields(out, *sheet.common, EdsPart::common);
    told[sheet.common->bank] = true;
  }
  const EdsImage image = sheet.image();
  for (std::size_t i = 0; i < max_channels; ++i) {
    const auto& part = sheet.profiles[i];
    if (!part || !part->whole || told[part->bank]) continue;
    // Without common part there is nothing to say in which bank it stands.
    if (!has_common && part->bank != i) continue;
    if (profile_part(image, i) != EdsPart::bp3) continue;
    heading(i == 0 ? "bp3" : fmt::format("bp3 {}", i));
    append_fields(out, *part, EdsPart::bp3);
    told[part->bank] = true;
  }
  for (unsigned number = 0; number < bank_count; ++number) {
    if (told[number] || dump.known_bytes(number) == 0) continue;
    heading(fmt::format("bank {}", number));
    append_rows(out, dump.bank(number), 0);
  }
  return out;
}

}  // namespace biss::cli
