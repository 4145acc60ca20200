// biss eds diff: two data sheets, symbol by symbol.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "biss/control/register_map.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/eds/rows.hpp"
#include "verbs/eds/source.hpp"

namespace biss::verbs {
namespace {

struct DiffOptions {
  EdsArguments first;
  std::string second;
  report::Format to = report::Format::table;
  std::string output;
};

/// The place of a value in a data sheet; rows are in this order.
struct RowOrder {
  unsigned part = 0;  // registers, common, profiles, further banks
  unsigned channel_or_bank = 0;
  unsigned address = 0;
  auto operator<=>(const RowOrder&) const = default;
};

/// A value, and the bytes that it is made of.
struct SheetValue {
  std::string part;
  std::string symbol;
  std::optional<std::uint64_t> value;
  std::string means;
  std::span<const std::optional<std::uint8_t>> bytes{};

  bool partly_known() const { return !value && dump::any_known(bytes); }
};

using SheetValues = std::map<RowOrder, SheetValue>;

void add_registers(SheetValues& values, const dump::RegisterDump& dump) {
  for (const RegisterField& field : register_fields) {
    if (field.address < dump::first_direct) continue;
    const bool number = field.bytes <= 6;
    const unsigned step = number ? field.bytes : 1U;
    for (unsigned at = field.address; at < field.address + unsigned{field.bytes}; at += step) {
      const auto value = dump.direct_number(at, step);
      values[{0, 0, at}] = {"registers",
                            number ? std::string(field.name) : fmt::format("0x{:02X}", at), value,
                            step == 1 || !value ? "" : fmt::format("0x{:0{}X}", *value, 2 * step),
                            std::span(dump.direct()).subspan(at - dump::first_direct, step)};
    }
  }
}

/// All values, known or not. \pre the source outlives them
SheetValues values_of(const EdsSource& source) {
  SheetValues values;
  add_registers(values, source.dump);
  std::set<unsigned> listed;
  for (const EdsFieldRow& row : eds_fields(source.sheet)) {
    listed.insert(row.bank);
    values[{row.channel ? 2U : 1U, row.channel.value_or(0), row.address}] = {
        part_text(row.part, row.channel), row.symbol, row.value, row.means,
        std::span(source.dump.bank(row.bank)).subspan(row.address, row.bytes)};
  }
  for (unsigned bank = 0; bank < bank_count; ++bank) {
    const auto whole = source.dump.whole_bank(bank);
    const bool erased = whole && is_filled_with(*whole, 0xFF);  // as files of banks have in between
    if (listed.contains(bank) || erased) continue;
    for (unsigned at = 0; at < bank_bytes; ++at) {
      const auto byte = std::span(source.dump.bank(bank)).subspan(at, 1);
      values[{3, bank, at}] = {
          fmt::format("bank {}", bank), fmt::format("0x{:02X}", at), byte.front(), {}, byte};
    }
  }
  return values;
}

// The known values. A field that is only partly present in one of the two is compared byte by byte.
SheetValues compared(const SheetValues& values, const SheetValues& others) {
  SheetValues sides;
  for (const auto& [place, field] : values) {
    const auto other = others.find(place);
    if (!field.partly_known() && (other == others.end() || !other->second.partly_known())) {
      if (field.value) sides[place] = field;
      continue;
    }
    for (unsigned i = 0; i < field.bytes.size(); ++i) {
      if (!field.bytes[i]) continue;
      const unsigned address = place.address + i;
      sides[{place.part, place.channel_or_bank, address}] = {
          field.part, fmt::format("0x{:02X}", address), field.bytes[i], {}};
    }
  }
  return sides;
}

// A file that has only banks cannot hold registers, so these do not differ.
bool comparable(const RowOrder& place, const dump::RegisterDump& other) {
  return place.part != 0 || other.direct() != dump::DumpedBytes{};
}

struct Difference {
  const SheetValue* a = nullptr;
  const SheetValue* b = nullptr;
};

std::vector<Difference> differences(const EdsSource& first, const EdsSource& second,
                                    const SheetValues& a, const SheetValues& b) {
  std::map<RowOrder, Difference> rows;
  for (const auto& [place, side] : a) rows[place].a = &side;
  for (const auto& [place, side] : b) rows[place].b = &side;
  std::vector<Difference> found;
  for (const auto& [place, each] : rows) {
    if (each.a != nullptr && each.b != nullptr && each.a->value == each.b->value) continue;
    if (each.a == nullptr && !comparable(place, first.dump)) continue;
    if (each.b == nullptr && !comparable(place, second.dump)) continue;
    found.push_back(each);
  }
  return found;
}

FieldRow difference_fields(const Difference& row) {
  static const SheetValue none;
  const SheetValue& a = row.a != nullptr ? *row.a : none;
  const SheetValue& b = row.b != nullptr ? *row.b : none;
  const SheetValue& any = row.a != nullptr ? a : b;
  return {{"part", any.part},
          {"symbol", any.symbol},
          {"a", a.value},
          {"b", b.value},
          {"means_a", unless_empty(a.means), {.heading = "a means"}},
          {"means_b", unless_empty(b.means), {.heading = "b means"}}};
}

ExitStatus run_diff(const DiffOptions& options, Host& host) {
  if (options.first.file == "-" && options.second == "-") {
    throw wrong_usage("only one of the two files can be stdin");
  }
  const EdsSource first = load_eds(options.first, host);
  EdsArguments arguments = options.first;
  arguments.file = options.second;
  const EdsSource second = load_eds(arguments, host);
  const SheetValues in_first = values_of(first);
  const SheetValues in_second = values_of(second);
  const SheetValues a = compared(in_first, in_second);
  const SheetValues b = compared(in_second, in_first);
  const auto rows = differences(first, second, a, b);
  const ExitStatus written = write_output(host, options.output, [&](Output& output) {
    return write_rows(rows, options.to, output, difference_fields);
  });
  return rows.empty() ? written : std::max(written, ExitStatus::data_failed);
}

}  // namespace

Run add_eds_diff(Verb verb) {
  const auto options = std::make_shared<DiffOptions>();
  verb.add_option("A", options->first.file, "Dump of registers or description; - is standard input")
      .required()
      .file(FileUse::read);
  verb.add_option("B", options->second,
                  "Second dump or description; the exit status is 1 if they differ")
      .required()
      .file(FileUse::read);
  add_count_option(verb, "--bank", into(options->first.bank),
                   "First bank of both files; 0 by default", 255);
  add_count_option(verb, "--eds-bank", into(options->first.eds_bank),
                   "Bank of both common parts, instead of register 0x41", 255);
  add_count_option(verb, "--slave", into(options->first.slave), "Read only the accesses to this ID",
                   7);
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_diff(*options, host); };
}

}  // namespace biss::verbs
