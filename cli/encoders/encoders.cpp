// biss encoders: the catalogue, what is known and what is not.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>
#include <string>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/safety/configurations.hpp"
#include "cli/common/format_option.hpp"
#include "cli/common/verb.hpp"
#include "cli/common/verbs.hpp"
#include "report/summary.hpp"

namespace biss::cli {
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

bool write_list(report::TextSink& sink, const report::TableOptions& table_options) {
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "name"},
      {.name = "vendor"},
      {.name = "format"},
      {.name = "clock", .kind = Kind::unsigned_integer, .unit = "MHz", .shift = 6, .places = 0},
      {.name = "doubts", .kind = Kind::unsigned_integer}};
  const auto table = report::make_table_writer(report::Format::table, columns, sink, table_options);
  for (const CatalogueEntry& entry : catalogue) {
    const std::size_t doubts = doubts_of(entry).size();
    const report::Cell cells[] = {
        entry.name, entry.vendor, entry.format,
        entry.clock_known() ? report::Cell(entry.timing.clock_max) : report::Cell(),
        doubts == 0 ? report::Cell() : report::Cell(doubts)};
    if (!table->row(cells)) return false;
  }
  return table->finish();
}

bool write_configurations(report::TextSink& sink, const report::TableOptions& table_options) {
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "safety configuration"},
      {.name = "format"},
      {.name = "compared", .kind = Kind::unsigned_integer},
      {.name = "cycle", .kind = Kind::unsigned_integer, .unit = "us", .shift = 6, .places = 2}};
  const auto table = report::make_table_writer(report::Format::table, columns, sink, table_options);
  for (const SafetyConfiguration& each : safety_configurations) {
    const unsigned compared = each.setup.comparison.compare_bits;
    const report::Cell cells[] = {
        each.name, each.format, compared == 0 ? report::Cell() : report::Cell(compared),
        report::Cell(static_cast<std::uint64_t>(each.setup.cycle_min.count))};
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
  known("  clock", fmt::format("{} to {}", text_of(timing.clock_min), text_of(timing.clock_max)));
  known("  ACK", ack_text(timing));
  known("  timeout", text_of(timing.timeout));
  if (timing.cycle_min != Picoseconds{}) known("  shortest cycle", text_of(timing.cycle_min));
  if (timing.internal_delay_max != Picoseconds{}) {
    known("  delay inside", fmt::format("at most {}", text_of(timing.internal_delay_max)));
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

ExitStatus run_encoders(const EncodersOptions& options) {
  const CatalogueEntry* entry = options.name.empty() ? nullptr : find_encoder(options.name);
  if (!options.name.empty() && entry == nullptr) {
    if (find_safety_configuration(options.name) != nullptr) {
      return fail(ExitStatus::usage,
                  fmt::format("'{}' is a safety configuration and no encoder: all there is to say "
                              "of it is in the list of 'biss encoders'",
                              options.name));
    }
    const std::string names = suggested_encoders(options.name);
    return fail(
        ExitStatus::usage,
        fmt::format("no encoder '{}' in the catalogue{} ('biss encoders' lists all)", options.name,
                    names.empty() ? "" : fmt::format("; did you mean {}?", names)));
  }
  Output output;
  if (!output.open(options.output)) return output.status();
  bool written = false;
  if (options.to != report::Format::table) {
    std::vector<const CatalogueEntry*> entries;
    if (entry != nullptr) entries.push_back(entry);
    for (const CatalogueEntry& each : catalogue) {
      if (entry == nullptr) entries.push_back(&each);
    }
    written = write_rows(entries, options.to, output);
  } else {
    const report::TableOptions table_options = output.table_options();
    written = entry != nullptr ? output.write(detail(*entry))
                               : write_list(output, table_options) && output.write("\n") &&
                                     write_configurations(output, table_options);
  }
  if (!written || !output.finish()) return output.status();
  if (entry == nullptr && options.to == report::Format::table) {
    print_summary(fmt::format(
        "\n{} encoders, {} safety configurations; -f takes both. A dash is what the source does "
        "not state.\n'biss encoders NAME' says what of an encoder is not certain, and "
        "how it behaves in time.\n",
        catalogue.size(), safety_configurations.size()));
  }
  return ExitStatus::done;
}

}  // namespace

void add_encoders(Command& command) {
  const auto options = std::make_shared<EncodersOptions>();
  Verb verb = command.add_verb(
      {.name = "encoders",
       .purpose = "List the encoders and safety configurations that -f knows by name",
       .examples = {"biss encoders", "biss encoders resolute-26", "biss encoders --to jsonl"}},
      [options] { return run_encoders(*options); });
  verb.add_option("NAME", options->name, "All there is to say of this one");
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
}

}  // namespace biss::cli
