#include "verbs/eds/source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <utility>

#include "biss/control/register_map.hpp"
#include "biss/eds/image.hpp"
#include "dump/read.hpp"
#include "dump/write.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/eds/description.hpp"
#include "verbs/eds/value.hpp"

namespace biss::verbs {
namespace {

using dump::DataSheet;
using dump::FoundPart;

std::string message_of(const dump::DumpError& error) {
  std::string text = dump::dump_error_text(error);
  if (error.cause == dump::DumpCause::several_slaves) text += "; select one with --slave";
  if (error.cause == dump::DumpCause::unknown_format || error.format == dump::DumpFormat::binary) {
    text += fmt::format("; the known kinds are {}, and descriptions ([common], TMA = 100ns)",
                        dump::known_formats);
  }
  return text;
}

Description read_file(const EdsArguments& arguments) {
  const auto fail = [&](const std::string& why) {
    return wrong_file("'{}': {}", arguments.file, why);
  };
  std::ifstream file;
  const bool is_stdin = arguments.file == "-";
  std::error_code ignored;
  if (!is_stdin && std::filesystem::is_directory(arguments.file, ignored)) {
    throw fail("is a folder");
  }
  if (!is_stdin) file.open(arguments.file, std::ios::binary);
  if (!file) throw fail("cannot be opened");
  std::istream& stream = is_stdin ? std::cin : file;
  std::string head = dump::read_head(stream);
  if (looks_like_description(head)) {
    auto described = read_description(stream, std::move(head));
    if (!described) throw fail("read as a description: " + described.error());
    return *std::move(described);
  }
  auto dump =
      dump::read_dump(stream, std::move(head), {.bank = arguments.bank, .slave = arguments.slave});
  if (!dump) throw fail(message_of(dump.error()));
  return {*std::move(dump), {}};
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

void make_override(EdsSource& source, const std::string& text) {
  const auto fail = [&](std::string_view why) {
    return wrong_usage("--override '{}': {}", text, why);
  };
  const std::size_t sign = text.find('=');
  if (sign == std::string::npos) throw fail("expected SYMBOL=value");
  const OverrideName name = override_name(std::string_view(text).substr(0, sign));
  const EdsField* field = nullptr;
  EdsPart part = EdsPart::common;
  for (const EdsPart each : {EdsPart::common, EdsPart::bp3}) {
    if (field != nullptr || (name.part && *name.part != each)) continue;
    field = find_field(fields_of(each), name.symbol);
    part = each;
  }
  if (field == nullptr) throw fail(fmt::format("no part has a field '{}'", name.symbol));
  FoundPart* const found = part_of(source.sheet, part, name.channel);
  if (found == nullptr) {
    throw fail(fmt::format("the dump does not hold the whole {} part", name_of(part)));
  }
  const bool linear = part == EdsPart::bp3 && parse_bp3_part(found->filled).linear();
  const auto value = parse_eds_value(*field, std::string_view(text).substr(sign + 1), linear);
  if (!value) throw fail(value.error());
  const bool sealed_before = found->filled[eds_checksum_address] == eds_checksum(found->filled);
  static_cast<void>(set_field(found->filled, *field, *value));
  if (sealed_before && field->kind != EdsKind::checksum) found->filled = sealed(found->filled);
  for (std::size_t i = 0; i < eds_bank_bytes; ++i) found->bytes[i] = found->filled[i];
  source.overrides.push_back(
      {part, static_cast<std::uint8_t>(name.channel), field->symbol, *value});
}

// BANK_i, DC_NUM and EDS_LEN decide which parts are found.
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
std::string nothing_found(const EdsSource& source, const EdsArguments& arguments) {
  if (arguments.eds_bank) {
    return fmt::format("--eds-bank {}: this bank is not in the dump", *arguments.eds_bank);
  }
  const auto stated = source.dump.direct_byte(reg::eds_bank);
  if (stated && *stated != 0 && *stated != 0xFF) {
    return fmt::format("register 0x41 places the data sheet in bank {}, which is not in the dump",
                       *stated);
  }
  if (stated) {
    return fmt::format(
        "register 0x41 is 0x{:02X}: the device has no data sheet; --eds-bank looks for one in a "
        "bank",
        *stated);
  }
  return "no bank looks like a data sheet; give the bank of the common part with --eds-bank";
}

}  // namespace

void add_eds_file(Verb verb, std::string& file, bool required) {
  verb.add_option("FILE", file,
                  "Dump of registers (binary, hex text, Intel HEX, or accesses as JSON lines) or "
                  "description; - is standard input")
      .required(required)
      .file(FileUse::read);
}

void add_eds_options(Verb verb, EdsArguments& arguments) {
  add_count_option(
      verb, "--bank", into(arguments.bank),
      "First bank of the file, 0 by default; for accesses, the bank selected before the first one",
      255);
  add_count_option(verb, "--eds-bank", into(arguments.eds_bank),
                   "Bank of the common part, instead of register 0x41", 255);
  add_count_option(verb, "--slave", into(arguments.slave), "Read only the accesses to this ID", 7);
  add_count_option(verb, "--id", into(arguments.identifier),
                   "Profile identifier, instead of the registers 0x42 and 0x43", 0xFFFF);
  verb.add_option(
          "--override", arguments.overrides,
          "Use this value instead of the stored one: TMA, common.CPOLY_0, bp3.1.MT_LEN; may "
          "be repeated")
      .type_name("SYMBOL=VALUE");
}

EdsSource load_eds(const EdsArguments& arguments, Host& host) {
  EdsSource source{read_file(arguments), {}, {}, {}};
  if (source.dump.without_bank != 0) {
    host.warn(fmt::format("'{}': {}", arguments.file, text_without_bank(source.dump)));
  }
  source.stored = find_data_sheet(
      source.dump, {.eds_bank = arguments.eds_bank, .identifier = arguments.identifier});
  source.sheet = source.stored;
  for (const std::string& text : arguments.overrides) make_override(source, text);
  if (!source.overrides.empty()) find_again(source, arguments);
  return source;
}

EdsSource load_eds_with_part(const EdsArguments& arguments, Host& host) {
  EdsSource source = load_eds(arguments, host);
  if (!source.sheet.empty()) return source;
  throw VerbError{ExitStatus::data_failed,
                  fmt::format("'{}': {}", arguments.file, nothing_found(source, arguments))};
}

}  // namespace biss::verbs
