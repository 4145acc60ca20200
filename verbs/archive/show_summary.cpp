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
#include "verbs/common/fields.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

namespace {

using archive::Counts;
using archive::FileEntry;
using archive::LinkEntry;
using archive::Quantity;
using archive::Reading;

std::optional<Picoseconds> median_of(const LinkEntry& link, Quantity quantity) {
  const auto& range = link.ranges[static_cast<std::size_t>(quantity)];
  return range ? std::optional(picoseconds(range->median)) : std::nullopt;
}

// Why the file was not read; if it was read, the most frequent fault, or that no fault can be seen.
std::string_view cause_of(const FileEntry& file, const LinkEntry* link) {
  if (link == nullptr || !file.cause.empty()) return file.cause;
  const auto foremost = link->counts.foremost_fault();
  const bool unchecked = link->counts.count(CycleStatus::unchecked) != 0;
  return name_of(foremost == CycleStatus::ok && unchecked ? CycleStatus::unchecked : foremost);
}

FieldRow fields_of(const FileEntry& file, const LinkEntry* found) {
  static const LinkEntry none;
  const LinkEntry& link = found != nullptr ? *found : none;
  const Counts& counts = link.counts;
  const auto if_found = [found](auto value) {
    return found != nullptr ? std::optional(value) : std::nullopt;
  };
  std::optional<Hertz> clock;
  if (const auto period = median_of(link, Quantity::period); period && period->count != 0) {
    clock = rate_of(*period);
  }
  return {{"file", file.path},
          {"ma", if_found(link.ma), {.heading = "MA"}},
          {"slo", if_found(link.slo), {.heading = "SLO"}},
          {"format", unless_empty(link.format)},
          {"cycles", if_found(counts.cycles)},
          {"faults", if_found(counts.faults())},
          {"cause", cause_of(file, found), {.role = report::Role::status}},
          {"errors", if_found(counts.errors)},
          {"warnings", if_found(counts.warnings)},
          {"limits", if_found(counts.limited)},
          {"marginal", counts.margin_judged != 0 ? std::optional(counts.marginal) : std::nullopt},
          {"line_delay_ns", median_of(link, Quantity::line_delay), rows::line_delay_column()},
          {"ack_ns", median_of(link, Quantity::ack), rows::ack_column()},
          {"clock_hz", clock, rows::clock_column()},
          {"date", file.day ? std::optional(archive::day_text(*file.day)) : std::nullopt}};
}

// \pre the files are in the order of is_worse()
ExitStatus write_table(const archive::Summary& summary, const SummaryOptions& options, Host& host) {
  std::vector<FieldRow> rows;
  for (std::size_t i = 0; i < summary.files.size() && i < options.worst; ++i) {
    const FileEntry& file = summary.files[i];
    if (file.links.empty()) rows.push_back(fields_of(file, nullptr));
    for (const LinkEntry& link : file.links) rows.push_back(fields_of(file, &link));
  }
  return write_output(host, "-", [&](Output& output) {
    return write_rows(fields_of({}, nullptr), rows, options.to, output, output.table_options());
  });
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
    report::append_count(status, sums.counts.count(each), name_of(each));
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
  for (const auto& [cause, count] : sums.causes) report::append_count(causes, count, cause);
  if (!causes.empty()) text.entry("not read", causes);
  const auto captures = captures_of(summary);
  text.entry("encoders", fmt::format("{}", captures.size()),
             "different folders, lines or frame formats");
  if (const auto [key, change] = largest_drift(captures); key != nullptr) {
    text.entry("drift",
               fmt::format("{}{} a year", change < 0 ? "-" : "+",
                           text_of(picoseconds(std::abs(change)), 3)),
               fmt::format("line delay in {}, the largest of all", key->folder));
  }
  return text.text();
}

}  // namespace

ExitStatus show_summary(archive::Summary& summary, const SummaryOptions& options, Host& host) {
  std::sort(summary.files.begin(), summary.files.end(), archive::is_worse);
  if (!options.output.empty()) {
    const ExitStatus status = write_output(
        host, options.output, [&](Output& output) { return write_summary(summary, output); });
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
