#include "cli/eds/source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <utility>

#include "biss/control/register_map.hpp"
#include "biss/eds/image.hpp"
#include "cli/common/verb.hpp"
#include "cli/eds/description.hpp"
#include "cli/eds/value.hpp"
#include "dump/read.hpp"

namespace biss::cli {
namespace {

using dump::DataSheet;
using dump::FoundPart;

/// A dump, or the line why there is none.
struct ReadDump {
  dump::RegisterDump dump;
  std::string error;
};

ReadDump read_stream(std::istream& stream, const EdsArguments& arguments) {
  std::string head = dump::read_head(stream);
  if (looks_like_description(head)) {
    DescribedDump described = read_description(stream, std::move(head));
    return {described.dump, std::move(described.error)};
  }
  const auto dump =
      dump::read_dump(stream, std::move(head), {.bank = arguments.bank, .slave = arguments.slave});
  if (dump.ok()) return {*dump, {}};
  const std::string hint =
      dump.error().cause == dump::DumpCause::several_slaves ? " (name it with --slave)" : "";
  return {{}, dump::dump_error_text(dump.error()) + hint};
}

ReadDump read_file(const EdsArguments& arguments) {
  if (arguments.file == "-") return read_stream(std::cin, arguments);
  std::error_code ignored;
  if (std::filesystem::is_directory(arguments.file, ignored)) return {{}, "is a folder"};
  std::ifstream file(arguments.file, std::ios::binary);
  if (!file) return {{}, "cannot be opened"};
  return read_stream(file, arguments);
}

// `SYMBOL`, `common.SYMBOL`, `bp3.SYMBOL`, `bp3.1.SYMBOL`.
struct OverrideName {
  std::optional<EdsPart> part;
  unsigned channel = 0;
  std::string_view symbol;
};

OverrideName override_name(std::string_view text) {
  OverrideName name{std::nullopt, 0, text};
  for (const EdsPart part : {EdsPart::common, EdsPart::bp3}) {
    const std::string prefix = fmt::format("{}.", name_of(part));
    if (!text.starts_with(prefix)) continue;
    name.part = part;
    name.symbol = text.substr(prefix.size());
  }
  const std::string_view rest = name.symbol;
  if (name.part == EdsPart::bp3 && rest.size() > 2 && rest[0] >= '0' && rest[0] <= '7' &&
      rest[1] == '.') {
    name.channel = static_cast<unsigned>(rest[0] - '0');
    name.symbol = rest.substr(2);
  }
  return name;
}

FoundPart* part_of(DataSheet& sheet, EdsPart part, unsigned channel) {
  auto& found = part == EdsPart::common ? sheet.common : sheet.profiles[channel];
  return found && found->whole ? &*found : nullptr;
}

// Returns why it cannot be made.
std::string make_override(EdsSource& source, const std::string& text) {
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos) return "expected SYMBOL=value";
  const OverrideName name = override_name(std::string_view(text).substr(0, sign));
  const EdsField* field = nullptr;
  EdsPart part = EdsPart::common;
  for (const EdsPart each : {EdsPart::common, EdsPart::bp3}) {
    if (field != nullptr || (name.part && *name.part != each)) continue;
    field = find_field(fields_of(each), name.symbol);
    part = each;
  }
  if (field == nullptr) return fmt::format("no part has a field '{}'", name.symbol);
  FoundPart* const found = part_of(source.sheet, part, name.channel);
  if (found == nullptr) {
    return fmt::format("the dump does not hold the whole {} part", name_of(part));
  }
  const bool linear = part == EdsPart::bp3 && parse_bp3_part(found->filled).linear();
  const EdsValue value = parse_eds_value(*field, std::string_view(text).substr(sign + 1), linear);
  if (!value.error.empty()) return value.error;
  const bool sealed_before = found->filled[eds_checksum_address] == eds_checksum(found->filled);
  static_cast<void>(set_field(found->filled, *field, value.value));
  if (sealed_before && field->kind != EdsKind::checksum) found->filled = sealed(found->filled);
  for (std::size_t i = 0; i < eds_bank_bytes; ++i) found->bytes[i] = found->filled[i];
  source.overrides.push_back(
      {part, static_cast<std::uint8_t>(name.channel), field->symbol, value.value});
  return {};
}

// BANK_i, DC_NUM and EDS_LEN decide what is found where.
void find_again(EdsSource& source, const EdsArguments& arguments) {
  if (!source.sheet.common || !source.sheet.eds_bank || !source.sheet.common->whole) return;
  dump::RegisterDump changed = source.dump;
  changed.set_bank(*source.sheet.eds_bank, source.sheet.common->filled);
  for (const auto& part : source.sheet.profiles) {
    if (part && part->whole) changed.set_bank(part->bank, part->filled);
  }
  source.sheet = find_data_sheet(
      changed, {.eds_bank = source.sheet.eds_bank, .identifier = arguments.identifier});
}

// Why no part was found.
std::string nothing_found(const EdsSource& source) {
  const auto stated = source.dump.direct_byte(reg::eds_bank);
  if (stated && *stated != 0 && *stated != 0xFF) {
    return fmt::format(
        "register 0x41 says that the data sheet is in bank {}, which the dump does "
        "not hold",
        *stated);
  }
  if (stated) {
    return fmt::format(
        "register 0x41 is 0x{:02X}: the device has no data sheet; --eds-bank looks "
        "for one all the same",
        *stated);
  }
  return "no bank looks like a data sheet; name the one with its common part: --eds-bank";
}

}  // namespace

void add_eds_file(Verb verb, std::string& file, bool required) {
  verb.add_option("FILE", file,
                  "A dump of registers (binary, hex text, Intel HEX, or accesses as JSON lines) or "
                  "a description; - is stdin")
      .required(required)
      .file(FileUse::read)
      .type_name("");
}

void add_eds_options(Verb verb, EdsArguments& arguments) {
  add_count_option(verb, "--bank", into(arguments.bank),
                   "The bank that the file begins with; 0 by default", 255);
  add_count_option(verb, "--eds-bank", into(arguments.eds_bank),
                   "The bank of the common part, instead of what register 0x41 says", 255);
  add_count_option(verb, "--slave", into(arguments.slave),
                   "Of accesses to several slaves, take those to this ID", 7);
  add_count_option(verb, "--id", into(arguments.identifier),
                   "The profile identifier of registers 0x42 and 0x43, instead of the dump's",
                   0xFFFF);
  verb.add_option("--override", arguments.overrides,
                  "Take this value for the one stored; TMA, common.CPOLY_0, bp3.1.MT_LEN; may be "
                  "repeated")
      .type_name("SYMBOL=VALUE");
}

LoadedEds load_eds(const EdsArguments& arguments) {
  ReadDump read = read_file(arguments);
  if (!read.error.empty()) {
    return {std::nullopt,
            fail(ExitStatus::io, fmt::format("'{}': {}", arguments.file, read.error))};
  }
  EdsSource source;
  source.dump = read.dump;
  source.stored = find_data_sheet(
      source.dump, {.eds_bank = arguments.eds_bank, .identifier = arguments.identifier});
  source.sheet = source.stored;
  for (const std::string& text : arguments.overrides) {
    const std::string error = make_override(source, text);
    if (!error.empty()) {
      return {std::nullopt,
              fail(ExitStatus::usage, fmt::format("--override '{}': {}", text, error))};
    }
  }
  if (!source.overrides.empty()) find_again(source, arguments);
  return {std::move(source), ExitStatus::done};
}

LoadedEds load_eds_with_part(const EdsArguments& arguments) {
  LoadedEds loaded = load_eds(arguments);
  if (!loaded.source || !loaded.source->sheet.empty()) return loaded;
  const std::string text = fmt::format("'{}': {}", arguments.file, nothing_found(*loaded.source));
  return {std::nullopt, fail(ExitStatus::data_failed, text)};
}

}  // namespace biss::cli
