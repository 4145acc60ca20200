#include "verbs/safety/campaign_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "verbs/common/host.hpp"

namespace biss::verbs {
namespace {

using lab::Acceptance;
using report::Kind;

constexpr std::array acceptances{Acceptance::cpw, Acceptance::spw, Acceptance::both,
                                 Acceptance::monitor, Acceptance::wrong};
// By chance a count deviates by more than this once in two million counts.
constexpr long double sigma_limit = 5;

std::string scientific(long double value) {
  return fmt::format("{:.6e}", static_cast<double>(value));
}

// A long double as the nearest double.
report::Cell real(long double value) { return static_cast<double>(value); }

std::vector<report::Column> machine_columns() {
  std::vector<report::Column> columns = {{.name = "fault"},
                                         {.name = "frames", .kind = Kind::unsigned_integer}};
  for (const char* name :
       {"accepted_cpw", "accepted_spw", "accepted_both", "accepted_monitor", "wrong"}) {
    columns.push_back({.name = name, .kind = Kind::unsigned_integer});
  }
  const auto add = [&columns](const std::string& name) {
    columns.push_back({.name = name, .kind = Kind::real});
  };
  for (const char* name : {"rate", "theory", "low", "high", "sigma"}) add(name);
  for (const char* what : {"cpw", "spw", "both", "monitor"}) {
    for (const char* name : {"rate", "theory", "sigma"}) add(fmt::format("{}_{}", what, name));
  }
  columns.push_back({.name = "missed"});
  for (const char* what : {"cpw_", "spw_", "both_", "monitor_", ""}) {
    add(fmt::format("{}effective", what));
  }
  return columns;
}

report::Cell events_cell(const CampaignRow& row, std::size_t what) {
  return row.estimates[what] ? report::Cell(row.counts.total(acceptances[what])) : report::Cell();
}

bool write_machine_row(report::TableWriter& table, const CampaignRow& row) {
  constexpr std::size_t wrong = lab::acceptance_count - 1;
  // Cells do not own their text.
  const std::string fault = text_of(row.fault);
  std::vector<report::Cell> cells = {report::Cell(fault), report::Cell(row.counts.frames)};
  for (std::size_t what = 0; what <= wrong; ++what) cells.push_back(events_cell(row, what));
  const auto add = [&](std::size_t what, bool bounds) {
    const auto& found = row.estimates[what];
    cells.push_back(found ? real(found->rate) : report::Cell());
    cells.push_back(row.theory ? real((*row.theory)[what]) : report::Cell());
    if (bounds) {
      cells.push_back(found ? real(found->low) : report::Cell());
      cells.push_back(found ? real(found->high) : report::Cell());
    }
    cells.push_back(found && found->sigma ? real(*found->sigma) : report::Cell());
  };
  add(wrong, true);
  for (std::size_t what = 0; what < wrong; ++what) add(what, false);
  const std::string missed = fmt::format("{}", fmt::join(row.counts.missed, ";"));
  cells.emplace_back(missed);
  for (const auto& found : row.estimates) {
    cells.push_back(found ? real(found->effective) : report::Cell());
  }
  return table.row(cells);
}

std::vector<report::Column> readable_columns() {
  return {{.name = "fault"},
          {.name = "accepted by"},
          {.name = "frames", .kind = Kind::unsigned_integer},
          {.name = "events", .kind = Kind::unsigned_integer},
          {.name = "effective"},
          {.name = "rate"},
          {.name = "low"},
          {.name = "high"},
          {.name = "theory"},
          {.name = "sigma"}};
}

bool write_readable_rows(report::TableWriter& table, const CampaignRow& row) {
  const std::string fault = text_of(row.fault);
  for (std::size_t what = 0; what < lab::acceptance_count; ++what) {
    if (!row.estimates[what]) continue;
    const lab::CampaignEstimate& found = *row.estimates[what];
    const std::string effective = fmt::format("{:.0f}", static_cast<double>(found.effective));
    const std::string rate = scientific(found.rate);
    const std::string low = scientific(found.low);
    const std::string high = scientific(found.high);
    const std::string theory = row.theory ? scientific((*row.theory)[what]) : "";
    const std::string sigma = found.sigma ? sigma_text(*found.sigma) : "";
    const report::Cell cells[] = {fault,
                                  lab::acceptance_names[what],
                                  row.counts.frames,
                                  events_cell(row, what),
                                  effective,
                                  rate,
                                  low,
                                  high,
                                  theory,
                                  sigma};
    if (!table.row(cells)) return false;
  }
  return true;
}

}  // namespace

std::string sigma_text(long double sigma) {
  std::string text = fmt::format("{:+.2f}", static_cast<double>(sigma));
  return text == "+0.00" || text == "-0.00" ? "0.00" : text;
}

std::vector<CampaignRow> campaign_rows(const lab::CampaignFrame& frame,
                                       const lab::CampaignState& state) {
  lab::CampaignTheories theories(frame);
  std::vector<CampaignRow> rows;
  for (std::size_t n = 0; n < state.plan.faults.size(); ++n) {
    const lab::FaultChoice& fault = state.plan.faults[n];
    CampaignRow row{fault, state.rows[n].counts, theories.of(fault)};
    for (std::size_t what = 0; what < lab::acceptance_count; ++what) {
      const auto theory = row.theory ? std::optional((*row.theory)[what]) : std::nullopt;
      if (!is_counted(fault, acceptances[what])) continue;
      row.estimates[what] = estimate(frame, fault, row.counts, acceptances[what], theory);
    }
    rows.push_back(row);
  }
  return rows;
}

bool write_campaign(std::span<const CampaignRow> rows, report::Format to, report::TextSink& sink,
                    const report::TableOptions& table_options) {
  const bool readable = to == report::Format::table;
  const auto columns = readable ? readable_columns() : machine_columns();
  const auto table = report::make_table_writer(to, columns, sink, table_options);
  for (const CampaignRow& row : rows) {
    if (!(readable ? write_readable_rows(*table, row) : write_machine_row(*table, row))) {
      return false;
    }
  }
  return table->finish();
}

ExitStatus judge_campaign(std::span<const CampaignRow> rows, Host& host) {
  for (const CampaignRow& row : rows) {
    for (const auto& found : row.estimates) {
      if (!found || !found->sigma || std::abs(*found->sigma) <= sigma_limit) continue;
      return host.fail(ExitStatus::data_failed,
                       "a count is more than five standard deviations from the theory");
    }
  }
  return ExitStatus::done;
}

}  // namespace biss::verbs
