// biss encoders: the catalogue of encoders and safety configurations.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/safety/configurations.hpp"
#include "report/summary.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/format_option.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {
namespace {

struct EncodersOptions {
  std::string name;
  report::Format to = report::Format::table;
  std::string output;
};

std::vector<std::string_view> doubts_of(const CatalogueEntry& entry) {
  std::vector<std::string_view> doubts(entry.uncertain.begin(), entry.uncertain.end());
  std::erase(doubts, std::string_view());
  return doubts;
}

// The entries that a word matches: all entries for an empty word.
struct Matches {
  std::vector<CatalogueEntry> encoders;
  std::vector<SafetyConfiguration> configurations;
};

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool contains(std::string_view text, std::string_view word) {
  const auto same = [](char a, char b) { return lower(a) == lower(b); };
  return std::search(text.begin(), text.end(), word.begin(), word.end(), same) != text.end();
}

// By name, maker and family. A safety configuration matches if the encoder matches from which it
// has its name.
Matches matches_of(std::string_view word) {
  Matches found;
  for (const CatalogueEntry& each : catalogue) {
    const bool matches =
        contains(each.name, word) || contains(each.vendor, word) || contains(each.product, word);
    if (matches) found.encoders.push_back(each);
  }
  for (const SafetyConfiguration& each : safety_configurations) {
    const bool matches =
        contains(each.name, word) ||
        std::any_of(found.encoders.begin(), found.encoders.end(),
                    [&](const auto& encoder) { return each.name.starts_with(encoder.name); });
    if (matches) found.configurations.push_back(each);
  }
  return found;
}

FieldRow list_fields(const CatalogueEntry& entry) {
  return {{"name", entry.name},
          {"vendor", entry.vendor},
          {"format", entry.format},
          {"clock",
           entry.clock_known() ? std::optional(entry.timing.clock_max) : std::nullopt,
           {.unit = "MHz", .shift = 6, .places = 0}},
          {"doubts", unless_0(doubts_of(entry).size())}};
}

FieldRow configuration_fields(const SafetyConfiguration& each) {
  return {{"safety configuration", each.name},
          {"format", each.format},
          {"compared", unless_0(unsigned{each.setup.comparison.compare_bits})},
          {"cycle",
           static_cast<std::uint64_t>(each.setup.cycle_min.count),
           {.unit = "us", .shift = 6, .places = 2}}};
}

bool write_lists(const Matches& found, Output& output) {
  constexpr auto table = report::Format::table;
  const bool both = !found.encoders.empty() && !found.configurations.empty();
  return write_rows(found.encoders, table, output, list_fields) && (!both || output.write("\n")) &&
         write_rows(found.configurations, table, output, configuration_fields);
}

std::string ack_text(const DeviceTiming& timing) {
  if (timing.ack_clocks != 0) return fmt::format("{} clocks", timing.ack_clocks);
  return fmt::format("at most {}", text_of(timing.ack_max));
}

std::string detail(const CatalogueEntry& entry) {
  const DeviceTiming& timing = entry.timing;
  report::Summary out;
  const auto known = [&out](std::string_view key, std::string_view value) {
    if (!value.empty()) out.entry(key, value);
  };
  out.title(fmt::format("{}: {} {}", entry.name, entry.vendor, entry.product));
  known("  format", entry.format);
  known("  resolution", entry.resolution);
  known("  remark", entry.remark);
  known("  clock", fmt::format("{} to {}{}", text_of(timing.clock_min), text_of(timing.clock_max),
                               timing.clock_constant ? ", constant within a request" : ""));
  known("  ACK", ack_text(timing));
  known("  timeout", text_of(timing.timeout));
  if (timing.cycle_min != Picoseconds{}) known("  shortest cycle", text_of(timing.cycle_min));
  if (timing.internal_delay_max != Picoseconds{}) {
    known("  internal delay", fmt::format("at most {}", text_of(timing.internal_delay_max)));
  }
  if (timing.sampling_typical != Picoseconds{}) {
    known("  position taken",
          fmt::format("{} to {} after the first rising edge of MA", text_of(timing.sampling_min),
                      text_of(timing.sampling_max)));
  }
  std::string_view key = "  not certain";
  for (const std::string_view doubt : doubts_of(entry)) {
    out.entry(key, doubt);
    key = "";
  }
  known("  source", entry.source);
  return out.text();
}

FieldRow encoder_fields(const CatalogueEntry& entry) {
  const DeviceTiming& timing = entry.timing;
  const bool fixed = timing.ack_clocks != 0;
  return {{"name", entry.name},
          {"vendor", entry.vendor},
          {"product", entry.product},
          {"format", entry.format},
          {"clock_min_hz", timing.clock_min},
          {"clock_max_hz", timing.clock_max},
          {"ack_max_ns", fixed ? std::nullopt : std::optional(timing.ack_max)},
          {"ack_clocks", unless_0(timing.ack_clocks)},
          {"timeout", text_of(timing.timeout)},
          {"cycle_min_ns", unless_0(timing.cycle_min)},
          {"internal_delay_ns", unless_0(timing.internal_delay_max)},
          {"resolution", entry.resolution},
          {"remark", entry.remark},
          {"uncertain", fmt::format("{}", fmt::join(doubts_of(entry), "; "))},
          {"source", entry.source}};
}

std::string no_match(const std::string& name) {
  const std::string names = suggested_encoders(name);
  return fmt::format(
      "no encoder with '{}' in its name, maker or family{} ('biss encoders' lists all)", name,
      names.empty() ? "" : fmt::format("; did you mean {}?", names));
}

ExitStatus run_encoders(const EncodersOptions& options, Host& host) {
  const CatalogueEntry* const exact = find_encoder(options.name);
  const bool as_table = options.to == report::Format::table;
  const Matches found = exact == nullptr ? matches_of(options.name) : Matches{{*exact}, {}};
  if (found.encoders.empty() && found.configurations.empty()) {
    return host.fail(ExitStatus::data_failed, no_match(options.name));
  }
  if (found.encoders.empty() && !as_table) {
    return host.fail(
        ExitStatus::data_failed,
        fmt::format("'{}' is a safety configuration, which only the table lists", options.name));
  }
  const ExitStatus written = write_output(host, options.output, [&](Output& output) {
    if (as_table)
      return exact != nullptr ? output.write(detail(*exact)) : write_lists(found, output);
    return write_rows(found.encoders, options.to, output, encoder_fields);
  });
  if (written == ExitStatus::done && exact == nullptr && as_table) {
    host.print_summary(fmt::format(
        "\n{}, {}; -f accepts both. A dash: the source does not "
        "state it.\n'biss encoders NAME' shows an encoder's timing and what is uncertain.\n",
        report::counted(found.encoders.size(), "encoder"),
        report::counted(found.configurations.size(), "safety configuration")));
  }
  return written;
}

}  // namespace

void add_encoders(Command& command) {
  const auto options = std::make_shared<EncodersOptions>();
  Verb verb = command.add_verb(
      {.name = "encoders",
       .purpose = "List the names of encoders and safety configurations that -f accepts",
       .examples = {"biss encoders", "biss encoders resolute-26", "biss encoders renishaw",
                    "biss encoders --to jsonl"}},
      [options](Host& host) { return run_encoders(*options, host); });
  verb.add_option(
      "NAME", options->name,
      "Name of an encoder, for its details; or a part of a name, maker or family, as a filter");
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
}

}  // namespace biss::verbs
