#include "tools/campaign_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace biss::tools {
namespace {

using lab::Acceptance;
using report::Kind;

constexpr std::array acceptances{Acceptance::cpw, Acceptance::spw, Acceptance::both,
                                 Acceptance::monitor, Acceptance::wrong};
// A campaign of 10^9 frames leaves the theory by more than this once in two million counts.
constexpr long double sigma_limit = 5;

std::string number(long double value) { return fmt::format("{:.6e}", static_cast<double>(value)); }

std::string signed_places(long double value) {
  return fmt::format("{:+.2f}", static_cast<double>(value));
}

// Theories take seconds; one row by importance sampling has the same as its plain one.
class Theories {
 public:
  explicit Theories(const lab::CampaignFrame& frame) : frame_(frame) {}

  const std::optional<lab::CampaignTheory>& of(lab::FaultChoice fault) {
    fault.drawn_rate = 0;
    const auto [at, fresh] = known_.try_emplace(text_of(fault));
    if (fresh) at->second = lab::campaign_theory(frame_, fault);
    return at->second;
  }

 private:
  const lab::CampaignFrame& frame_;
  std::map<std::string, std::optional<lab::CampaignTheory>> known_;
};

struct Measured {
  std::string fault;
  const lab::CampaignCounts& counts;
  std::optional<lab::CampaignTheory> theory;
  std::array<lab::CampaignEstimate, lab::acceptance_count> estimates{};

  std::optional<std::string> theory_text(std::size_t what) const {
    if (!theory) return std::nullopt;
    return number((*theory)[what]);
  }
  std::optional<std::string> sigma_text(std::size_t what) const {
    if (!estimates[what].sigma) return std::nullopt;
    return signed_places(*estimates[what].sigma);
  }
};

std::vector<report::Column> machine_columns() {
  std::vector<report::Column> columns = {{.name = "fault"},
                                         {.name = "frames", .kind = Kind::unsigned_integer}};
  for (const char* name :
       {"accepted_cpw", "accepted_spw", "accepted_both", "accepted_monitor", "wrong"}) {
    columns.push_back({.name = name, .kind = Kind::unsigned_integer});
  }
  for (const char* name : {"rate", "theory", "low", "high", "sigma"}) {
    columns.push_back({.name = name});
  }
  for (const char* what : {"cpw", "spw", "both", "monitor"}) {
    for (const char* name : {"rate", "theory", "sigma"}) {
      columns.push_back({.name = fmt::format("{}_{}", what, name)});
    }
  }
  columns.push_back({.name = "missed"});
  return columns;
}

bool write_machine_row(report::TableWriter& table, const Measured& row) {
  // Cells own no text.
  constexpr std::size_t wrong = lab::acceptance_count - 1;
  const auto text = [](const std::optional<std::string>& value) {
    return value ? report::Cell(*value) : report::Cell();
  };
  std::vector<report::Cell> cells = {report::Cell(row.fault), report::Cell(row.counts.frames)};
  for (const Acceptance what : acceptances) cells.emplace_back(row.counts.total(what));
  const std::string rate = number(row.estimates[wrong].rate);
  const std::string low = number(row.estimates[wrong].low);
  const std::string high = number(row.estimates[wrong].high);
  std::array<std::string, wrong> rates;
  std::array<std::optional<std::string>, lab::acceptance_count> theories;
  std::array<std::optional<std::string>, lab::acceptance_count> sigmas;
  for (std::size_t what = 0; what < lab::acceptance_count; ++what) {
    if (what < wrong) rates[what] = number(row.estimates[what].rate);
    theories[what] = row.theory_text(what);
    sigmas[what] = row.sigma_text(what);
  }
  cells.insert(cells.end(), {report::Cell(rate), text(theories[wrong]), report::Cell(low),
                             report::Cell(high), text(sigmas[wrong])});
  for (std::size_t what = 0; what < wrong; ++what) {
    cells.insert(cells.end(),
                 {report::Cell(rates[what]), text(theories[what]), text(sigmas[what])});
  }
  const std::string missed = fmt::format("{}", fmt::join(row.counts.missed, ";"));
  cells.emplace_back(missed);
  return table.row(cells);
}

std::vector<report::Column> eye_columns() {
  return {{.name = "fault"},
          {.name = "accepted by"},
          {.name = "frames", .kind = Kind::unsigned_integer},
          {.name = "events", .kind = Kind::unsigned_integer},
          {.name = "rate"},
          {.name = "low"},
          {.name = "high"},
          {.name = "theory"},
          {.name = "sigma"}};
}

bool write_eye_rows(report::TableWriter& table, const Measured& row) {
  for (std::size_t what = 0; what < lab::acceptance_count; ++what) {
    const lab::CampaignEstimate& estimate = row.estimates[what];
    const std::string rate = number(estimate.rate);
    const std::string low = number(estimate.low);
    const std::string high = number(estimate.high);
    const auto theory = row.theory_text(what);
    const auto sigma = row.sigma_text(what);
    const report::Cell cells[] = {row.fault,
                                  lab::acceptance_names[what],
                                  row.counts.frames,
                                  row.counts.total(acceptances[what]),
                                  rate,
                                  low,
                                  high,
                                  theory ? report::Cell(*theory) : report::Cell(),
                                  sigma ? report::Cell(*sigma) : report::Cell()};
    if (!table.row(cells)) return false;
  }
  return true;
}

}  // namespace

CampaignTable write_campaign(const lab::CampaignFrame& frame, const lab::CampaignState& state,
                             report::Format to, report::TextSink& sink, bool colour) {
  const bool eyes = to == report::Format::table;
  const auto columns = eyes ? eye_columns() : machine_columns();
  const auto table = report::make_table_writer(to, columns, sink, {.colour = colour});
  Theories theories(frame);
  CampaignTable result;
  for (std::size_t n = 0; n < state.plan.faults.size(); ++n) {
    const lab::FaultChoice& fault = state.plan.faults[n];
    Measured row{text_of(fault), state.counts[n], theories.of(fault)};
    for (std::size_t what = 0; what < lab::acceptance_count; ++what) {
      const auto theory = row.theory ? std::optional((*row.theory)[what]) : std::nullopt;
      row.estimates[what] = estimate(frame, fault, row.counts, acceptances[what], theory);
      const auto& sigma = row.estimates[what].sigma;
      if (sigma && std::abs(*sigma) > sigma_limit) result.disagrees = true;
    }
    if (!(eyes ? write_eye_rows(*table, row) : write_machine_row(*table, row))) return result;
  }
  result.written = table->finish();
  return result;
}

}  // namespace biss::tools
