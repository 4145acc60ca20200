// Writes the summary of an archive as a table or as text.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "device/quantity.hpp"
#include "report/summary.hpp"
#include "rows/columns.hpp"
#include "verbs/archive/archive.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

namespace {

using archive::Counts;
using archive::FileEntry;
using archive::LinkEntry;
using archive::Quantity;
using archive::Reading;
using report::Cell;
using report::Kind;

std::vector<report::Column> worst_columns() {
  return {{.name = "file"},
          {.name = "ma", .heading = "MA"},
          {.name = "slo", .heading = "SLO"},
          {.name = "format"},
          {.name = "cycles", .kind = Kind::unsigned_integer},
          {.name = "faults", .kind = Kind::unsigned_integer},
          {.name = "cause", .role = report::Role::status},
          {.name = "errors", .kind = Kind::unsigned_integer},
          {.name = "warnings", .kind = Kind::unsigned_integer},
          {.name = "limits", .kind = Kind::unsigned_integer},
          {.name = "marginal", .kind = Kind::unsigned_integer},
          rows::line_delay_column(),
          rows::ack_column(),
          rows::clock_column(),
          {.name = "date"}};
}

std::optional<std::int64_t> median_of(const LinkEntry& link, Quantity quantity) {
  const auto& range = link.ranges[static_cast<std::size_t>(quantity)];
  return range ? std::optional(range->median) : std::nullopt;
}

Cell time_cell(const std::optional<std::int64_t>& time) {
  return time ? Cell(picoseconds(*time)) : Cell();
}

// Why the file was not read; if it was read, the most frequent fault, or that no fault can be seen.
std::string_view cause_of(const FileEntry& file, const LinkEntry* link) {
  if (!file.cause.empty()) return file.cause;
  const auto foremost = link->counts.foremost_fault();
  const bool unchecked = link->counts.count(CycleStatus::unchecked) != 0;
  return name_of(foremost == CycleStatus::ok && unchecked ? CycleStatus::unchecked : foremost);
}

bool put_row(report::TableWriter& writer, const FileEntry& file, const LinkEntry* link) {
  const std::string date = file.day ? archive::day_text(*file.day) : "";
  std::vector<Cell> cells(15);
  cells[0] = file.path;
  cells[6] = cause_of(file, link);
  if (file.day) cells[14] = date;
  if (link != nullptr) {
    const Counts& counts = link->counts;
    cells[1] = link->ma;
    cells[2] = link->slo;
    if (!link->format.empty()) cells[3] = link->format;
    cells[4] = counts.cycles;
    cells[5] = counts.faults();
    cells[7] = counts.errors;
    cells[8] = counts.warnings;
    cells[9] = counts.limited;
    if (counts.margin_judged != 0) cells[10] = counts.marginal;
    cells[11] = time_cell(median_of(*link, Quantity::line_delay));
    cells[12] = time_cell(median_of(*link, Quantity::ack));
    if (const auto period = median_of(*link, Quantity::period); period && *period != 0) {
      cells[13] = rate_of(picoseconds(*period));
    }
  }
  return writer.row(cells);
}

// \pre the files are in the order of is_worse()
ExitStatus write_table(const archive::Summary& summary, const SummaryOptions& options, Host& host) {
  Output output(host);
  if (!output.open("-")) return output.status();
  const auto columns = worst_columns();
  const auto writer =
      report::make_table_writer(options.to, columns, output, output.table_options());
  std::uint64_t rows = 0;
  for (const FileEntry& file : summary.files) {
    if (rows == options.worst) break;
    ++rows;
    bool written = true;
    if (file.links.empty()) written = put_row(*writer, file, nullptr);
    for (const LinkEntry& link : file.links) written = written && put_row(*writer, file, &link);
    if (!written || output.reader_left()) break;
  }
  return writer->finish() && output.finish() ? ExitStatus::done : output.status();
}

std::string with_comma(const std::string& list, std::uint64_t count, std::string_view name) {
  return fmt::format("{}{}{} {}", list, list.empty() ? "" : ", ", count, name);
}

// The encoder whose line delay changes the most, in picoseconds a year.
std::pair<const archive::GroupKey*, std::int64_t> largest_drift(
    const std::map<archive::GroupKey, std::vector<archive::PlacedLink>>& captures) {
  std::pair<const archive::GroupKey*, std::int64_t> largest{nullptr, 0};
  for (const auto& [key, links] : captures) {
    const auto change = archive::change_per_year(medians_of(links, Quantity::line_delay));
    if (change && std::abs(*change) > std::abs(largest.second)) largest = {&key, *change};
  }
  return largest;
}

std::string sums_text(const archive::Summary& summary, const archive::Totals& sums,
                      const std::string& name) {
  const auto read = [&](Reading reading) {
    return sums.by_reading[static_cast<std::size_t>(reading)];
  };
  report::Summary text;
  text.title(fmt::format("{}: {} files, {} read, {} in part, {} not read", name,
                         summary.files.size(), read(Reading::whole), read(Reading::part),
                         read(Reading::none)));
  std::string status;
  for (std::size_t i = 0; i < cycle_status_count; ++i) {
    const auto each = static_cast<CycleStatus>(i);
    if (sums.counts.count(each) != 0) {
      status = with_comma(status, sums.counts.count(each), name_of(each));
    }
  }
  text.entry("cycles", fmt::format("{}", sums.counts.cycles), status);
  text.entry("flags", fmt::format("{} with nE = 0, {} with nW = 0", sums.counts.errors,
                                  sums.counts.warnings));
  if (sums.counts.limited != 0) text.entry("limits", fmt::format("{}", sums.counts.limited));
  if (sums.counts.margin_judged != 0) {
    text.entry("marginal",
               fmt::format("{} of {}", sums.counts.marginal, sums.counts.margin_judged));
  }
  std::string causes;
  for (const auto& [cause, count] : sums.causes) causes = with_comma(causes, count, cause);
  if (!causes.empty()) text.entry("not read", causes);
  const auto captures = captures_of(summary);
  text.entry("encoders", fmt::format("{}", captures.size()),
             "different folders, lines or frame formats");
  if (const auto [key, change] = largest_drift(captures); key != nullptr) {
    text.entry("drift",
               fmt::format("{}{} a year", change < 0 ? "-" : "+",
                           text_of(picoseconds(std::abs(change)), 3)),
               fmt::format("line delay in {}, the most of all", key->folder));
  }
  return text.text();
}

ExitStatus write_json(const archive::Summary& summary, const std::string& path, Host& host) {
  Output output(host);
  if (!output.open(path)) return output.status();
  return write_summary(summary, output) && output.finish() ? ExitStatus::done : output.status();
}

}  // namespace

ExitStatus show_summary(archive::Summary& summary, const SummaryOptions& options, Host& host) {
  std::sort(summary.files.begin(), summary.files.end(), archive::is_worse);
  if (!options.output.empty()) {
    const ExitStatus status = write_json(summary, options.output, host);
    if (status != ExitStatus::done) return status;
  }
  if (options.output != "-") {
    const ExitStatus status = write_table(summary, options, host);
    if (status != ExitStatus::done) return status;
  }
  const std::string name = options.output.empty() ? "archive" : options.output;
  const archive::Totals sums = totals_of(summary);
  host.print_summary(sums_text(summary, sums, name));
  if (summary.parts.complete() && sums.counts.cycles == 0) {
    return host.fail(ExitStatus::data_failed, fmt::format("{}: no file has a request cycle", name));
  }
  return ExitStatus::done;
}

}  // namespace biss::verbs
