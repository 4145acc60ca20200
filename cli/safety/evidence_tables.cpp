// The tables of the bundle but the line model's: analysis, campaign, coverage, matrix.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "cli/safety/analysis.hpp"
#include "cli/safety/campaign_plan.hpp"
#include "cli/safety/campaign_table.hpp"
#include "cli/safety/evidence.hpp"
#include "lab/wilson.hpp"
#include "report/table.hpp"

namespace biss::cli {
namespace {

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> parts(1);
  for (const char letter : text) {
    if (letter == at) {
      parts.emplace_back();
    } else {
      parts.back() += letter;
    }
  }
  return parts;
}

// A table of campaign.csv, whose cells are never quoted.
using CsvRow = std::map<std::string, std::string>;
std::vector<CsvRow> csv_rows(std::string_view csv) {
  std::vector<std::string> lines = split(csv, '\n');
  lines.pop_back();
  const std::vector<std::string> names = split(lines.front(), ',');
  std::vector<CsvRow> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> cells = split(lines[i], ',');
    CsvRow& row = rows.emplace_back();
    for (std::size_t k = 0; k < names.size() && k < cells.size(); ++k) row[names[k]] = cells[k];
  }
  return rows;
}

// Flips leave some frames as they were: those are no faults.
double damaged_share(const lab::CampaignFrame& frame, const lab::FaultChoice& fault) {
  if (fault.kind != lab::CampaignFault::flips) return 1;
  const long double whole =
      static_cast<long double>(frame.bits()) * std::log1p(-lab::probability_of(fault.rate));
  return static_cast<double>(-std::expm1(whole));
}

CoverageRow campaign_row(const lab::CampaignFrame& frame, const lab::FaultChoice& fault,
                         const CsvRow& cells) {
  const double damaged = damaged_share(frame, fault);
  const auto share = [&](const char* name) {
    return std::min(1.0, std::stod(cells.at(name)) / damaged);
  };
  CoverageRow row{.kind = name_of(TransmissionError::corruption),
                  .by = "campaign",
                  .fault = cells.at("fault"),
                  .detected = {},
                  .theory = {},
                  .reaction = {},
                  .verdicts = {}};
  const double frames = std::stod(cells.at("frames"));
  row.committed =
      static_cast<std::uint64_t>(std::llround(fault.weighed() ? frames : frames * damaged));
  row.accepted_wrong = std::stoull(cells.at("wrong"));
  row.share = share("rate");
  row.low = share("low");
  row.high = share("high");
  if (!cells.at("theory").empty()) row.theory = share("theory");
  return row;
}

std::string scientific(double value) { return fmt::format("{:.6e}", value); }

// Rounded down: a coverage is never said to be better than it was.
std::string coverage_text(double missed_share) {
  constexpr double places = 1e9;
  return fmt::format("{:.9f}", std::floor((1 - missed_share) * places) / places);
}

}  // namespace

std::string verdicts_text(const VerdictCounts& counts) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] != 0) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return counts[a] > counts[b]; });
  std::string text;
  for (const std::size_t i : order) {
    text += fmt::format("{}{}:{}", text.empty() ? "" : " ", name_of(static_cast<SafetyVerdict>(i)),
                        counts[i]);
  }
  return text;
}

void set_share(CoverageRow& row) {
  if (row.committed == 0) return;
  const auto trials = static_cast<long double>(row.committed);
  const long double share = static_cast<long double>(row.accepted_wrong) / trials;
  const lab::ShareLimits limits = lab::wilson_limits(share, trials);
  row.share = static_cast<double>(share);
  row.low = static_cast<double>(limits.low);
  row.high = static_cast<double>(limits.high);
}

EvidencePart evidence_analysis(const EvidenceQuestion& question) {
  const SafetyComparison& comparison = question.setup.comparison;
  const SafetyQuestion asked{
      .format = question.format,
      .bit_error_rates = question.bit_error_rates,
      .frame_rate = question.rate,
      .limit_per_hour = 1e-9,
      .checks = {.compare_bits = comparison.compare_bits,
                 .tolerance_lsb = comparison.tolerance_lsb,
                 .compare_turns = comparison.multiturn == MultiturnRule::with_carry},
      .gap_bits = 8};
  const SafetyAnalysis analysis = analyse(asked);
  EvidencePart part;
  part.files = {{"analysis.jsonl", analysis_jsonl(asked, analysis)},
                {"analysis.txt", analysis_text(asked, analysis)}};
  if (analysis.pair_problem) {
    part.findings.push_back(
        fmt::format("analysis.jsonl: the two words are not counted together: {}",
                    lab::text_of(*analysis.pair_problem)));
  }
  return part;
}

EvidencePart evidence_campaign(const EvidenceQuestion& question) {
  EvidencePart part;
  const auto frame = lab::CampaignFrame::make(question.format, question.setup);
  if (!frame) {
    part.error = "these two words are too long for the campaign: 64 bits a word, 126 together";
    return part;
  }
  lab::CampaignPlan plan{.format = campaign_name(question),
                         .rules = campaign_rules(*frame),
                         .seed = question.options.seed,
                         .frames = question.options.frames,
                         .faults = {}};
  for (const std::string& fault : usual_campaign_faults()) add_campaign_fault(*frame, fault, plan);
  add_importance(*frame, plan);
  lab::CampaignState state(plan);
  lab::run_campaign(*frame, state, {.threads = question.threads});
  report::StringSink csv;
  if (write_campaign(*frame, state, report::Format::csv, csv, false).disagrees) {
    part.findings.push_back(
        "campaign.csv: a count is more than five standard deviations from the theory");
  }
  const std::vector<CsvRow> rows = csv_rows(csv.text());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    part.coverage.push_back(campaign_row(*frame, plan.faults[n], rows[n]));
  }
  part.files = {{"campaign.csv", csv.text()}, {"campaign.json", lab::state_text(state)}};
  return part;
}

EvidenceFile evidence_coverage(const std::vector<CoverageRow>& rows) {
  report::StringSink sink;
  using report::Cell;
  using report::Kind;
  const std::vector<report::Column> columns = {
      {.name = "kind"},
      {.name = "by"},
      {.name = "fault"},
      {.name = "committed", .kind = Kind::unsigned_integer},
      {.name = "accepted_wrong", .kind = Kind::unsigned_integer},
      {.name = "dc"},
      {.name = "dc_low"},
      {.name = "dc_high"},
      {.name = "dc_theory"},
      {.name = "share"},
      {.name = "share_low"},
      {.name = "share_high"},
      {.name = "share_theory"},
      {.name = "detected", .kind = Kind::unsigned_integer},
      {.name = "reaction_cycles", .kind = Kind::unsigned_integer},
      {.name = "verdicts"}};
  const auto table = report::make_table_writer(report::Format::csv, columns, sink);
  for (const CoverageRow& row : rows) {
    const bool any = row.committed != 0;
    const std::string texts[] = {
        coverage_text(row.share), coverage_text(row.high),
        coverage_text(row.low),   row.theory ? coverage_text(*row.theory) : "",
        scientific(row.share),    scientific(row.low),
        scientific(row.high),     row.theory ? scientific(*row.theory) : ""};
    std::vector<Cell> cells = {row.kind, row.by, row.fault, row.committed, row.accepted_wrong};
    for (std::size_t i = 0; i < std::size(texts); ++i) {
      cells.push_back(any && !texts[i].empty() ? Cell(texts[i]) : Cell());
    }
    cells.insert(cells.end(), {Cell(row.detected), Cell(row.reaction), Cell(row.verdicts)});
    table->row(cells);
  }
  table->finish();
  return {"coverage.csv", sink.text()};
}

// From the document itself, so that there is one list.
EvidenceFile evidence_matrix() {
  report::StringSink sink;
  const std::vector<report::Column> columns = {
      {.name = "requirement"}, {.name = "source"}, {.name = "test"}};
  const auto table = report::make_table_writer(report::Format::csv, columns, sink);
  bool inside = false;
  for (const std::string& line : split(safety_matrix_page, '\n')) {
    if (line.starts_with("| requirement |")) inside = true;
    if (line.empty()) inside = false;
    if (!inside || line.starts_with("| requirement |") || line.starts_with("|---")) continue;
    const std::vector<std::string> cells = split(line, '|');
    if (cells.size() != 5) continue;
    const auto trimmed = [&](std::size_t k) { return cells[k].substr(1, cells[k].size() - 2); };
    // A row a test; each stands in backquotes.
    const std::vector<std::string> parts = split(cells[3], '`');
    for (std::size_t k = 1; k < parts.size(); k += 2) {
      const std::string texts[] = {trimmed(1), trimmed(2), parts[k]};
      const report::Cell row[] = {texts[0], texts[1], texts[2]};
      table->row(row);
    }
  }
  table->finish();
  return {"matrix.csv", sink.text()};
}

}  // namespace biss::cli
