// The table of a fault campaign.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "verbs/common/host.hpp"
#include "verbs/safety/experiments.hpp"

namespace biss::verbs {
namespace {

using lab::Acceptance;

// By chance a count deviates by more than this once in two million counts.
constexpr long double sigma_limit = 5;

std::optional<long double> theory_of(const CampaignRow& row, std::size_t what) {
  return row.theory ? std::optional((*row.theory)[what]) : std::nullopt;
}

std::optional<std::uint64_t> events_of(const CampaignRow& row, std::size_t what) {
  return row.estimates[what] ? std::optional(row.counts.total(static_cast<Acceptance>(what)))
                             : std::nullopt;
}

// A row for programs.
FieldRow fields_of(const CampaignRow& row) {
  constexpr auto wrong = static_cast<std::size_t>(Acceptance::wrong);
  FieldRow fields{{"fault", text_of(row.fault)}, {"frames", row.counts.frames}};
  const auto name_of = [](std::size_t what) { return std::string(lab::acceptance_names[what]); };
  for (std::size_t what = 0; what < wrong; ++what) {
    fields.emplace_back("accepted_" + name_of(what), events_of(row, what));
  }
  fields.emplace_back("wrong", events_of(row, wrong));
  const auto add = [&](const std::string& name, std::size_t what, auto member) {
    std::optional<long double> value;
    if (const auto& found = row.estimates[what]) value = (*found).*member;
    fields.emplace_back((what == wrong ? "" : name_of(what) + "_") + name, value);
  };
  using lab::CampaignEstimate;
  const auto add_estimate = [&](std::size_t what) {
    add("rate", what, &CampaignEstimate::rate);
    fields.emplace_back((what == wrong ? "" : name_of(what) + "_") + "theory",
                        theory_of(row, what));
    if (what == wrong) {
      add("low", what, &CampaignEstimate::low);
      add("high", what, &CampaignEstimate::high);
    }
    add("sigma", what, &CampaignEstimate::sigma);
  };
  add_estimate(wrong);
  for (std::size_t what = 0; what < wrong; ++what) add_estimate(what);
  fields.emplace_back("missed", fmt::format("{}", fmt::join(row.counts.missed, ";")));
  for (std::size_t what = 0; what <= wrong; ++what) {
    add("effective", what, &CampaignEstimate::effective);
  }
  return fields;
}

// A row for people: one check of a fault.
FieldRow readable_fields(const CampaignRow& row, std::size_t what) {
  const lab::CampaignEstimate& found = *row.estimates[what];
  const auto scientific = [](std::optional<long double> value) {
    return value ? fmt::format("{:.6e}", static_cast<double>(*value)) : "";
  };
  return {{"fault", text_of(row.fault)},
          {"accepted by", lab::acceptance_names[what]},
          {"frames", row.counts.frames},
          {"events", events_of(row, what)},
          {"effective", fmt::format("{:.0f}", static_cast<double>(found.effective))},
          {"rate", scientific(found.rate)},
          {"low", scientific(found.low)},
          {"high", scientific(found.high)},
          {"theory", scientific(theory_of(row, what))},
          {"sigma", found.sigma ? sigma_text(*found.sigma) : ""}};
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
    CampaignRow& row =
        rows.emplace_back(CampaignRow{fault, state.rows[n].counts, theories.of(fault)});
    for (std::size_t what = 0; what < lab::acceptance_count; ++what) {
      const auto acceptance = static_cast<Acceptance>(what);
      if (!is_counted(fault, acceptance)) continue;
      row.estimates[what] = estimate(frame, fault, row.counts, acceptance, theory_of(row, what));
    }
  }
  return rows;
}

std::vector<FieldRow> campaign_table(std::span<const CampaignRow> rows, report::Format to) {
  std::vector<FieldRow> table;
  for (const CampaignRow& row : rows) {
    if (to != report::Format::table) table.push_back(fields_of(row));
    for (std::size_t what = 0; to == report::Format::table && what < row.estimates.size(); ++what) {
      if (row.estimates[what]) table.push_back(readable_fields(row, what));
    }
  }
  return table;
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
