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
  std::vector<const CatalogueEntry*> encoders;
  std::vector<const SafetyConfiguration*> configurations;
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
    if (matches) found.encoders.push_back(&each);
  }
  for (const SafetyConfiguration& each : safety_configurations) {
    const bool matches =
        contains(each.name, word) ||
        std::any_of(found.encoders.begin(), found.encoders.end(),
                    [&](const auto* encoder) { return each.name.starts_with(encoder->name); });
    if (matches) found.configurations.push_back(&each);
  }
  return found;
}

bool write_list(const Matches& found, report::TextSink& sink, const report::TableOptions& options) {
  if (found.encoders.empty()) return true;
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "name"},
      {.name = "vendor"},
      {.name = "format"},
      {.name = "clock", .kind = Kind::unsigned_integer, .unit = "MHz", .shift = 6, .places = 0},
      {.name = "doubts", .kind = Kind::unsigned_integer}};
  const auto table = report::make_table_writer(report::Format::table, columns, sink, options);
  for (const CatalogueEntry* entry : found.encoders) {
    const std::size_t doubts = doubts_of(*entry).size();
    const report::Cell cells[] = {
        entry->name, entry->vendor, entry->format,
        entry->clock_known() ? report::Cell(entry->timing.clock_max) : report::Cell(),
        doubts == 0 ? report::Cell() : report::Cell(doubts)};
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

bool write_configurations(const Matches& found, report::TextSink& sink,
                          const report::TableOptions& options) {
  if (found.configurations.empty()) return true;
  if (!found.encoders.empty() && !sink.write("\n")) return false;
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "safety configuration"},
      {.name = "format"},
      {.name = "compared", .kind = Kind::unsigned_integer},
      {.name = "cycle", .kind = Kind::unsigned_integer, .unit = "us", .shift = 6, .places = 2}};
  const auto table = report::make_table_writer(report::Format::table, columns, sink, options);
  for (const SafetyConfiguration* each : found.configurations) {
    const unsigned compared = each->setup.comparison.compare_bits;
    const report::Cell cells[] = {
        each->name, each->format, compared == 0 ? report::Cell() : report::Cell(compared),
        report::Cell(static_cast<std::uint64_t>(each->setup.cycle_min.count))};
    if (!table->row(cells)) return false;
  }
  return table->finish();
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

bool write_rows(const std::vector<const CatalogueEntry*>& entries, report::Format format,
                report::TextSink& sink) {
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "name"},
      {.name = "vendor"},
      {.name = "product"},
      {.name = "format"},
      {.name = "clock_min_hz", .kind = Kind::unsigned_integer},
      {.name = "clock_max_hz", .kind = Kind::unsigned_integer},
      {.name = "ack_max_ns", .kind = Kind::nanoseconds},
      {.name = "ack_clocks", .kind = Kind::unsigned_integer},
      {.name = "timeout"},
      {.name = "cycle_min_ns", .kind = Kind::nanoseconds},
      {.name = "internal_delay_ns", .kind = Kind::nanoseconds},
      {.name = "resolution"},
      {.name = "remark"},
      {.name = "uncertain"},
      {.name = "source"}};
  const auto table = report::make_table_writer(format, columns, sink);
  const auto given = [](Picoseconds time) {
    return time == Picoseconds{} ? report::Cell() : report::Cell(time);
  };
  for (const CatalogueEntry* entry : entries) {
    const DeviceTiming& timing = entry->timing;
    const bool fixed = timing.ack_clocks != 0;
    const std::string timeout = text_of(timing.timeout);
    const std::string doubts = fmt::format("{}", fmt::join(doubts_of(*entry), "; "));
    const report::Cell cells[] = {entry->name,
                                  entry->vendor,
                                  entry->product,
                                  entry->format,
                                  timing.clock_min,
                                  timing.clock_max,
                                  fixed ? report::Cell() : report::Cell(timing.ack_max),
                                  fixed ? report::Cell(timing.ack_clocks) : report::Cell(),
                                  timeout,
                                  given(timing.cycle_min),
                                  given(timing.internal_delay_max),
                                  entry->resolution,
                                  entry->remark,
                                  doubts,
                                  entry->source};
    if (!table->row(cells)) return false;
  }
  return table->finish();
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
  const Matches found = exact == nullptr ? matches_of(options.name) : Matches{{exact}, {}};
  if (found.encoders.empty() && found.configurations.empty()) {
    return host.fail(ExitStatus::data_failed, no_match(options.name));
  }
  if (found.encoders.empty() && !as_table) {
    return host.fail(
        ExitStatus::data_failed,
        fmt::format("'{}' is a safety configuration, which only the table lists", options.name));
  }
  Output output(host);
  if (!output.open(options.output)) return output.status();
  const report::TableOptions table_options = output.table_options();
  const bool written = !as_table          ? write_rows(found.encoders, options.to, output)
                       : exact != nullptr ? output.write(detail(*exact))
                                          : write_list(found, output, table_options) &&
                                                write_configurations(found, output, table_options);
  if (!written || !output.finish()) return output.status();
  if (exact == nullptr && as_table) {
    host.print_summary(fmt::format(
        "\n{} encoder{}, {} safety configuration{}; -f accepts both. A dash: the source does not "
        "state it.\n'biss encoders NAME' shows an encoder's timing and what is uncertain.\n",
        found.encoders.size(), found.encoders.size() == 1 ? "" : "s", found.configurations.size(),
        found.configurations.size() == 1 ? "" : "s"));
  }
  return ExitStatus::done;
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
