// Files of the bundle that are made from the tables of its commands: coverage.csv, README.md,
// matrix.csv.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "device/quantity.hpp"
#include "lab/campaign_fault.hpp"
#include "lab/pair.hpp"
#include "lab/sequence.hpp"
#include "lab/statistics.hpp"
#include "lab/weights.hpp"
#include "report/summary.hpp"
#include "sim/fault.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/safety/evidence.hpp"
#include "verbs/safety/setup_fields.hpp"

namespace biss::verbs {
namespace {

// Flips leave some frames as they were: these are not faults.
double damaged_share(const SafetyFormat& monitored, const lab::FaultChoice& fault) {
  if (fault.rate == 0) return 1;
  const unsigned bits = monitored.cpw().total_bits() + monitored.spw().total_bits();
  const long double whole =
      static_cast<long double>(bits) * std::log1p(-lab::probability_of(fault.rate));
  return static_cast<double>(-std::expm1(whole));
}

CoverageRow campaign_row(const SafetyFormat& monitored, const CampaignRow& result) {
  const double damaged = damaged_share(monitored, result.fault);
  const auto share = [damaged](long double rate) {
    return std::min(1.0, static_cast<double>(rate) / damaged);
  };
  constexpr auto wrong = static_cast<std::size_t>(lab::Acceptance::wrong);
  const lab::CampaignEstimate& found = *result.estimates[wrong];
  const auto frames = static_cast<double>(result.counts.frames);
  CoverageRow row{.error = std::string(name_of(TransmissionError::corruption)),
                  .by = "campaign",
                  .fault = text_of(result.fault),
                  .injected = static_cast<std::uint64_t>(
                      std::llround(result.fault.weighted() ? frames : frames * damaged)),
                  .accepted_wrong = result.counts.total(lab::Acceptance::wrong),
                  .share = share(found.rate),
                  .low = share(found.low),
                  .high = share(found.high)};
  if (result.theory) row.theory = share((*result.theory)[wrong]);
  return row;
}

// A row whose instances were counted one by one, with the worst reaction of the detected ones.
CoverageRow counted_row(CoverageRow row, std::uint64_t reaction,
                        const std::array<std::uint64_t, safety_verdict_count>& verdicts) {
  if (row.detected != 0U) row.reaction = reaction;
  row.verdicts = verdicts_text(verdicts);
  set_share(row);
  return row;
}

// An accepted event counts whatever the position of the accepted frame is.
CoverageRow sequence_row(const lab::SequenceResult& result) {
  const lab::SequenceCounts& counts = result.counts;
  CoverageRow row{.error = std::string(result.row.name()),
                  .by = "sequences",
                  .fault = std::string(result.row.variant_name()),
                  .injected = counts.events,
                  .detected = counts.detected(),
                  .accepted_wrong = counts.accepted};
  if (result.theory) row.theory = static_cast<double>(*result.theory);
  return counted_row(std::move(row), counts.worst_cycles, counts.verdicts);
}

CoverageRow line_row(sim::FaultKind kind, const LineCounts& counts) {
  const auto error = entry_of(kind).error;
  return counted_row({.error = std::string(error ? name_of(*error) : "encoder"),
                      .by = "line",
                      .fault = std::string(name_of(kind)),
                      .injected = counts.injected,
                      .detected = counts.detected,
                      .accepted_wrong = counts.accepted_wrong},
                     counts.reaction, counts.verdicts);
}

std::string scientific(double value) { return fmt::format("{:.6e}", value); }

// Rounded down, so that the coverage is never overstated.
std::string coverage_text(double missed_share) {
  constexpr double places = 1e9;
  return fmt::format("{:.9f}", std::floor((1 - missed_share) * places) / places);
}

template <class... Args>
void add(std::string& text, fmt::format_string<Args...> what, Args&&... args) {
  text += fmt::format(what, std::forward<Args>(args)...);
}

void add_files(std::string& text, const std::vector<EvidenceCommand>& commands) {
  text += "## Files\n";
  for (const EvidenceCommand& each : commands) {
    add(text, "* `{}`: `{}`\n", each.file, command_line(each.arguments));
  }
  text +=
      "* `coverage.csv`: diagnostic coverage of each fault, from these tables\n"
      "* `configuration.json`: the frame, every parameter of the monitor; the other verbs take it "
      "with\n  `-f configuration.json`\n"
      "* `manifest.json`: the commands above with their exit statuses, the options of this "
      "bundle\n"
      "* `version.json`: the program\n"
      "* `matrix.csv`: requirement, source, test\n"
      "* `safety.md`, `safety-matrix.md`: parameters, verdicts, states; which test covers what\n"
      "* `SHA256SUMS`: for `sha256sum -c SHA256SUMS`\n\n"
      "The same options give the same bytes with any number of threads.\n"
      "`biss safety evidence --check DIR` makes the bundle again and compares.\n"
      "No file has a date, a machine or a path in it.\n"
      "`biss safety campaign -f … --fault FAULT --seed N --replay NUMBER` shows a frame that\n"
      "`campaign.csv` lists as missed.\n\n";
}

void add_rating(std::string& text, const EvidenceSubject& subject) {
  const SafetyFormat& monitored = subject.monitored;
  const SafetySetup& setup = monitored.setup;
  add(text,
      "## Undetected errors and rating\n"
      "On a binary symmetric channel with a bit error rate of {:g}, with the comparison of this "
      "configuration.\n\n",
      lab::rated_bit_error_rate);
  if (const auto shares = lab::undetected_shares(monitored.format, monitored.setup.comparison)) {
    const auto frames = 3600 * static_cast<long double>(subject.rate.count);
    add(text,
        "| position | protected by | per frame | per hour at {} |\n|---|---|---:|---:|\n"
        "| safe position (`low`, `high`) | both CRCs, nE, counter, comparison | {:.3g} | {:.3g} |\n"
        "| control position (`cpw_only_…`) | below the compared bits only the CPW's CRC | {:.3g} | "
        "{:.3g} |\n\n"
        "`analysis.txt` counts an error of the safe position by the CPW; here the larger number of "
        "CPW and\nSPW is given.\n\n",
        text_of(subject.rate), shares->safe_position(), shares->safe_position() * frames,
        shares->control_position, shares->control_position * frames);
  } else {
    text += "The two words cannot be analysed together: see `analysis.txt`.\n\n";
  }
  const double limit = static_cast<double>(setup.residual_max_e15) * 1e-15;
  if (const auto mistake = check_safety(monitored.format, setup)) {
    add(text,
        "**Not rated:** `check_safety()` returns `{}`: {}. The limit\n(`residual_max_e15`) is {:g} "
        "an hour, at a frame every `frame_gap_min`, {}.\n\n",
        name_of(*mistake), message_of(*mistake), limit, text_of(setup.frame_gap_min));
  } else {
    add(text,
        "**Rated:** `check_safety()` accepts this configuration: at most {:g} undetected errors an "
        "hour\n(`residual_max_e15`), at a frame every `frame_gap_min`, {}.\n\n",
        limit, text_of(setup.frame_gap_min));
  }
  text +=
      "1 % of the limit of SIL 2 is 1e-08 an hour, of SIL 3 1e-09 (IEC 61784-3). The encoder's "
      "certificates and\nthe assessment decide what a safety function may claim: see *What may be "
      "claimed* in `safety.md`.\n\n";
}

void add_unchecked(std::string& text, const SafetyFormat& monitored) {
  const SafetySetup& setup = monitored.setup;
  const SafetyFormat::UncheckedBits bits = monitored.unchecked_bits();
  const auto alignment =
      safety_detail::alignment_of(monitored.cpw(), monitored.spw(), setup.comparison);
  add(text,
      "## What is not checked in this configuration\n"
      "`safety-matrix.md` explains each point.\n\n"
      "* **CPW bits below the SPW's resolution: {}.**\n"
      "* **CPW bits that both words have and that `compare_bits` leaves out: {}.**\n"
      "* **Turns of the CPW that are not compared: {}.**\n",
      bits.below_resolution, bits.not_compared, bits.turns);
  if (bits.all() != 0) {
    const CrcSpec& crc = monitored.cpw().crc;
    const unsigned distance = lab::min_distance(lab::weights_of(lab::code_of(monitored.cpw())));
    add(text,
        "* Only the CPW's CRC protects these {} of {} bits. It detects every error of up to {} "
        "bits and every\n  burst of up to {}, and accepts about one in {} of the others.\n",
        bits.all(), monitored.cpw().position_bits(), distance - 1, crc.width_bits,
        1U << crc.width_bits);
  }
  const std::uint64_t counts = setup.comparison.tolerance_lsb;
  if (counts != 0) {
    add(text,
        "* **A difference of up to {}** of the lowest bit compared, in the CPW {}, is "
        "permanently `safe`.\n",
        report::counted(counts, "count"), counts << alignment.cpw_shift);
  }
  const unsigned period = counter_period(setup.counter.mode);
  add(text,
      "* **A frame of another encoder** with the expected counter: one in {}; **a frame exactly {} "
      "frames old**.\n",
      period, period);
  text +=
      "* **A position that is frozen in both words**, **both words wrong in the same way**, and "
      "**nW**.\n";
  if (setup.counter.first == any_first_value) {
    text +=
        "* **A constant delay since power-up**: answers that are all late by the same number of "
        "requests.\n  The counter's first value (`SafetyCounter::first`) is not given; only a "
        "stimulus\n  (`expect_position()`) shows this delay.\n";
  }
  add(text,
      "* **A clock at a wrong rate, with one clock** (`OneClock`, as in these commands). Two "
      "clocks "
      "(`TwoClocks`)\n  may differ by up to {} between good frames.{}\n",
      text_of(setup.clocks.tolerance),
      setup.clocks.bit_period.count == 0 ? " The time of a transfer is not checked." : "");
  if (setup.budget.faults != 0) {
    add(text,
        "* **Up to {} faults in {}** are tolerated: only the positions of their frames are "
        "withheld.\n",
        setup.budget.faults, text_of(setup.budget.window));
  }
  text += '\n';
}

// Faults of one kind, as `NAME` (BY).
template <class Which>
void add_list(std::string& text, const char* title, const std::vector<CoverageRow>& coverage,
              const Which& which) {
  std::vector<std::string> names;
  for (const CoverageRow& row : coverage) {
    if (which(row)) names.push_back(fmt::format("`{}` ({})", row.fault, row.by));
  }
  if (!names.empty()) add(text, "\n**{}:** {}.\n", title, fmt::join(names, ", "));
}

void add_coverage(std::string& text, const std::vector<CoverageRow>& coverage) {
  text +=
      "## Diagnostic coverage, as measured\n"
      "In `coverage.csv`, DC is 1 - accepted wrong / injected: the share of the **modelled** "
      "instances of a\nfault after which no wrong position is `safe` (sequences: no frame at all "
      "that must not be). It is not\nthe diagnostic coverage of IEC 61508, which weighs the real "
      "failures of a real device. `dc_low` and\n`dc_high` are 95 % limits (two-sided). Importance "
      "sampling (`flips:RATE:DRAWN`, `flips:RATE:fitting`)\ndraws other frames and weighs them: "
      "there accepted wrong / injected is not the share.\n";
  add_list(text, "Never injected, so nothing is known of them", coverage,
           [](const CoverageRow& row) { return row.injected == 0; });
  add_list(text, "Never detected", coverage, [](const CoverageRow& row) {
    return row.injected != 0 && row.accepted_wrong == row.injected;
  });
}

}  // namespace

void set_share(CoverageRow& row) {
  if (row.injected == 0) return;
  const auto trials = static_cast<long double>(row.injected);
  const long double share = static_cast<long double>(row.accepted_wrong) / trials;
  const lab::ShareLimits limits = lab::wilson_limits(share, trials);
  row.share = static_cast<double>(share);
  row.low = static_cast<double>(limits.low);
  row.high = static_cast<double>(limits.high);
}

std::vector<CoverageRow> coverage_of(const SafetyFormat& monitored, const LineResult& line,
                                     std::span<const CampaignRow> campaign,
                                     std::span<const lab::SequenceResult> sequences) {
  std::vector<CoverageRow> rows;
  for (std::size_t k = 0; k < line.size(); ++k) {
    rows.push_back(line_row(static_cast<sim::FaultKind>(k), line[k]));
  }
  for (const CampaignRow& each : campaign) rows.push_back(campaign_row(monitored, each));
  for (const lab::SequenceResult& each : sequences) {
    const bool is_sum = each.row.variant_name() == "all";
    if (each.row.task == lab::SequenceTask::fault && !is_sum) rows.push_back(sequence_row(each));
  }
  return rows;
}

EvidenceFile coverage_file(const std::vector<CoverageRow>& rows) {
  std::vector<FieldRow> table;
  for (const CoverageRow& row : rows) {
    const auto known = [&row](std::optional<double> value, auto text_of) {
      return row.injected != 0 && value ? std::optional(text_of(*value)) : std::nullopt;
    };
    table.push_back({{"error", row.error},
                     {"by", row.by},
                     {"fault", row.fault},
                     {"injected", row.injected},
                     {"accepted_wrong", row.accepted_wrong},
                     {"dc", known(row.share, coverage_text)},
                     {"dc_low", known(row.high, coverage_text)},
                     {"dc_high", known(row.low, coverage_text)},
                     {"dc_theory", known(row.theory, coverage_text)},
                     {"share", known(row.share, scientific)},
                     {"share_low", known(row.low, scientific)},
                     {"share_high", known(row.high, scientific)},
                     {"share_theory", known(row.theory, scientific)},
                     {"detected", row.detected},
                     {"reaction_cycles", row.reaction},
                     {"verdicts", row.verdicts}});
  }
  return {"coverage.csv", text_of(table, report::Format::csv)};
}

EvidenceFile matrix_file() {
  std::vector<FieldRow> table;
  std::string requirement;
  std::string source;
  std::istringstream page(safety_matrix_page);
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("### ")) requirement = line.substr(4);
    if (line.starts_with("## ")) requirement.clear();
    if (line.starts_with("Source: ")) source = line.substr(8);
    if (requirement.empty() || !line.starts_with("* `")) continue;
    table.push_back({{"requirement", requirement},
                     {"source", source},
                     {"test", line.substr(3, line.size() - 4)}});
  }
  return {"matrix.csv", text_of(table, report::Format::csv)};
}

std::vector<std::string> not_run(const EvidenceOptions& options) {
  std::vector<std::string> parts;
  if (options.frames == 0) {
    parts.emplace_back("campaign.csv and the undamaged frames of sequences.csv (--frames 0)");
  }
  if (options.faults == 0) parts.emplace_back("the faults of sequences.csv (--faults 0)");
  if (options.cycles == 0) parts.emplace_back("line.csv (--cycles 0)");
  return parts;
}

std::string page_of_bundle(std::string_view page) {
  std::string text;
  for (;;) {
    const auto label_end = page.find("](");
    const auto end = page.find(')', label_end);
    if (end == page.npos) return text.append(page);
    const std::string_view before = page.substr(0, label_end);
    const auto closed = before.rfind(']');
    const auto label = before.find('[', closed == before.npos ? 0 : closed);
    const std::string_view link = page.substr(label_end + 2, end - label_end - 2);
    if (label == before.npos || link.starts_with("safety.md") ||
        link.starts_with("safety-matrix.md")) {
      text.append(page.substr(0, label_end + 1));
      page.remove_prefix(label_end + 1);
    } else {
      text.append(before.substr(0, label)).append(before.substr(label + 1));
      page.remove_prefix(end + 1);
    }
  }
}

EvidenceFile readme_file(const EvidenceSubject& subject,
                         const std::vector<EvidenceCommand>& commands,
                         const std::vector<CoverageRow>& coverage) {
  std::string text = fmt::format("# BiSS Safety: evidence for {}\n\n", subject.options.format);
  text +=
      "Made by `biss safety evidence`. All figures describe models of a channel (see `safety.md`). "
      "They are\nnot a certificate.\n\n";
  for (const std::string& each : not_run(subject.options)) {
    add(text, "**Nothing was run: {}.**\n\n", each);
  }
  bool failed = false;
  for (const EvidenceCommand& each : commands) {
    if (each.status == 0) continue;
    failed = true;
    add(text, "**Finding:** `{}` ended with exit status {}; see its file.\n\n",
        command_line(each.arguments), each.status);
  }
  if (!failed) {
    text +=
        "Every command ended with exit status 0: no count is more than five standard deviations "
        "from its\ntheory, no undamaged frame has a fault verdict, and no fault is detected late "
        "or "
        "under a name that\nit cannot have.\n\n";
  }
  add_files(text, commands);
  add_rating(text, subject);
  add_unchecked(text, subject.monitored);
  add_coverage(text, coverage);
  return {"README.md", std::move(text)};
}

}  // namespace biss::verbs
