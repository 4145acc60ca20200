// README.md of the bundle: what each file is, how it is made again, and what it does not show.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>
#include <regex>

#include "biss/frame/format_text.hpp"
#include "biss/safety/configurations.hpp"
#include "cli/common/quantity.hpp"
#include "cli/safety/campaign_plan.hpp"
#include "cli/safety/evidence.hpp"
#include "lab/weights.hpp"

namespace biss::cli {
namespace {

template <class... Args>
void add(std::string& text, fmt::format_string<Args...> what, Args&&... args) {
  fmt::format_to(std::back_inserter(text), what, std::forward<Args>(args)...);
}

// For a command line: no space before the unit.
template <class Quantity>
std::string typed(Quantity quantity) {
  std::string text = text_of(quantity);
  std::erase(text, ' ');
  return text;
}

std::string format_of(const EvidenceQuestion& question) {
  return std::string(format_text(question.format).view());
}

std::string analyse_command(const EvidenceQuestion& question) {
  const SafetyComparison& comparison = question.setup.comparison;
  std::string text = fmt::format("biss safety analyse -f '{}'", format_of(question));
  for (const double rate : question.bit_error_rates) add(text, " --ber {}", rate);
  add(text, " --rate {}", typed(question.rate));
  if (comparison.compare_bits != 0) add(text, " --compare {}", comparison.compare_bits);
  if (comparison.tolerance_lsb != 1) add(text, " --tolerance {}", comparison.tolerance_lsb);
  if (comparison.multiturn == MultiturnRule::ignored) text += " --ignore-turns";
  return text;
}

// Empty where `biss safety campaign` would monitor by another setup.
std::string campaign_command(const EvidenceQuestion& question) {
  const std::string name = campaign_name(question);
  const auto theirs = campaign_frame_of(name);
  const auto ours = lab::CampaignFrame::make(question.format, question.setup);
  if (!theirs || !ours || campaign_rules(*theirs) != campaign_rules(*ours)) return {};
  return fmt::format("biss safety campaign -f '{}' --frames {} --seed {}", name,
                     question.options.frames, question.options.seed);
}

// The same for the sequences, whose times count too.
std::string sequences_command(const EvidenceQuestion& question) {
  const auto* known = find_safety_configuration(question.configuration);
  if (!(question.setup == (known != nullptr ? known->setup : SafetySetup{}))) return {};
  return fmt::format("biss safety sequences -f '{}' --frames {} --faults {} --seed {}",
                     campaign_name(question), question.options.frames, question.options.faults,
                     question.options.seed);
}

void add_files(std::string& text, const EvidenceQuestion& question) {
  const std::string whole = "`biss safety evidence --check DIR`";
  const std::string campaign = campaign_command(question);
  const std::string analyse = analyse_command(question);
  const auto command = [&](const std::string& line, const char* more) {
    return line.empty() ? whole : fmt::format("`{}{}`", line, more);
  };
  text += "## Files\n| file | what it is | made again by |\n|---|---|---|\n";
  add(text, "| `version.json` | the program that made this | |\n");
  add(text,
      "| `configuration.json` | every option, the frame bit by bit, every parameter of the "
      "monitor, the seed | {} |\n",
      whole);
  add(text,
      "| `analysis.jsonl`, `analysis.txt` | what the checksums and both words do not see, "
      "exactly | {}, and without `--to jsonl` |\n",
      command(analyse, " --to jsonl"));
  add(text, "| `campaign.csv` | damaged frames, what was accepted, the theory beside it | {} |\n",
      command(campaign, " --to csv"));
  add(text, "| `campaign.json` | the counts behind it, to be merged and replayed | {} |\n",
      command(campaign, " --state campaign.json"));
  add(text,
      "| `sequences.csv` | frames in order: undamaged ones, and the eight kinds of fault, the "
      "theory beside them | {} |\n",
      command(sequences_command(question), " --to csv"));
  add(text,
      "| `line.csv` | each fault of the line model: detected, harmless, accepted wrong | {} |\n",
      whole);
  add(text, "| `coverage.csv` | diagnostic coverage per fault, of all these tables | {} |\n",
      whole);
  add(text, "| `matrix.csv` | requirement, source, test | {} |\n", whole);
  text +=
      "| `safety.md`, `safety-matrix.md` | parameters, verdicts and states; what is checked by "
      "which test | |\n"
      "| `SHA256SUMS` | `sha256sum -c SHA256SUMS` holds all files against it | |\n\n"
      "All of it, the bytes of this page included, comes again from the same options with "
      "any number of threads; `biss safety evidence --check DIR` does that and compares. "
      "Nothing in it is a date, a machine or a path.\n\n";
  if (campaign.empty()) {
    text +=
        "The campaign was run with a setup for which the verb `campaign` has no options, so only "
        "`--check` makes it again.\n\n";
  } else {
    add(text,
        "A frame that the campaign lists as missed is shown again by `biss safety campaign "
        "-f '{}' --fault FAULT --seed {} --replay NUMBER`.\n\n",
        campaign_name(question), question.options.seed);
  }
}

void add_configuration(std::string& text, const EvidenceQuestion& question) {
  const SafetySetup& setup = question.setup;
  const auto alignment =
      safety_detail::alignment_of(question.cpw(), question.spw(), setup.comparison);
  const auto* known = find_safety_configuration(question.configuration);
  text += "## Configuration\n";
  add(text, "* Frame `{}`, monitored as: {}.\n", format_of(question), question.configuration);
  if (known != nullptr) add(text, "* Source of that configuration: {}.\n", known->source);
  for (const ChannelFormat* word : {&question.cpw(), &question.spw()}) {
    const bool is_cpw = word == &question.cpw();
    add(text, "* {}: {} data bits, CRC of {} bits, 0x{:X}, start 0x{:X}, {}.\n",
        is_cpw ? "Control position word (CPW)" : "Safety position word (SPW)", word->data_bits,
        word->crc.width_bits, word->crc.polynomial, word->crc.start,
        word->crc.inverted ? "sent inverted" : "sent plain");
  }
  add(text, "* Compared: {} bits, {} of them turns, up to {} counts of the lowest one apart.\n",
      alignment.bits, alignment.bits - alignment.singleturn_bits, setup.comparison.tolerance_lsb);
  add(text, "* {} requests a second; the watchdog bites {} after the last good frame.\n\n",
      question.rate.count, text_of(setup.frame_gap_max));
}

void add_tolerated(std::string& text, const SafetySetup& setup, unsigned cpw_shift) {
  const std::uint64_t counts = setup.comparison.tolerance_lsb;
  add(text,
      "* **A difference of up to {} count{}** of the lowest bit compared, in the CPW {}, is `safe` "
      "for good.\n",
      counts, counts == 1 ? "" : "s", counts << cpw_shift);
}

void add_unchecked(std::string& text, const EvidenceQuestion& question) {
  const SafetySetup& setup = question.setup;
  const UncheckedBits bits = unchecked_bits(question);
  const auto alignment =
      safety_detail::alignment_of(question.cpw(), question.spw(), setup.comparison);
  const CrcSpec& crc = question.cpw().crc;
  text += "## What is not checked in this configuration\n";
  add(text, "* **CPW bits below the SPW's resolution: {}.** ", bits.below_resolution);
  text += bits.below_resolution == 0 ? "Each singleturn bit of the CPW has one in the SPW.\n"
                                     : "The SPW does not have them.\n";
  add(text,
      "* **CPW bits that both words have and that are not compared: {}** (`compare_bits` "
      "{}; 0 is all).\n",
      bits.not_compared, setup.comparison.compare_bits);
  add(text, "* **Turns of the CPW that are not compared: {}.**{}\n", bits.turns,
      setup.comparison.multiturn == MultiturnRule::ignored ? " They are ignored by option."
      : bits.turns != 0                                    ? " The SPW does not have them."
                                                           : "");
  if (bits.all() != 0) {
    const unsigned distance = lab::min_distance(lab::weights_of(lab::code_of(question.cpw())));
    add(text,
        "* For these {} of {} bits nothing but the CPW's CRC stands: it finds every error of "
        "up to {} bits and every burst of up to {}, and lets about one in {} of the others "
        "pass. A safety function must not rely on them.\n",
        bits.all(), question.cpw().position_bits(), distance - 1, crc.width_bits,
        1U << crc.width_bits);
  }
  if (setup.comparison.tolerance_lsb != 0) add_tolerated(text, setup, alignment.cpw_shift);
  text +=
      "* **A position that stands still in both words** while the sign of life goes on "
      "(`frozen` in line.csv).\n"
      "* **Both words wrong in the same way**: a scale that slipped, a wrong zero. That is for "
      "the encoder's own diagnosis, by nE.\n";
  add(text,
      "* **The frame of another encoder of the same format** with the right counter: one in "
      "{}; CRC start values that differ would tell it.\n",
      counter_period(setup.counter.mode));
  add(text,
      "* **A frame that is exactly {} frames old**, in the place of the one that is due: the sign "
      "of life has the same value again (`any_age` in sequences.csv).\n",
      counter_period(setup.counter.mode));
  add(text, "* **nW** is told and not judged.\n");
  if (setup.budget.faults != 0) {
    add(text,
        "* **Up to {} faults in {}** are tolerated: they withhold their frame's position and "
        "nothing else.\n",
        setup.budget.faults, text_of(setup.budget.window));
  }
  text += '\n';
}

void add_assumptions(std::string& text, const EvidenceQuestion& question) {
  text +=
      "## What is assumed\n"
      "* **All figures speak of models of a channel, none is a certificate.** A safety "
      "function's claim is decided by its own assessment. No public text gives the formula "
      "by which BiSS Safety was assessed.\n"
      "* Analysis: a binary symmetric channel, each bit wrong independently of the others; "
      "START, CDS and STOP read right, except under faults of structure.\n"
      "* Campaign: positions and counters drawn evenly, nE and nW 1, the encoder's two words "
      "agree exactly, the frames before were good.\n";
  text +=
      "* Sequences: encoders that move at full speed; a frame every cycle to one and a half; the "
      "faults are committed in the ways of `docs/safety-sequences.md`, each as often.\n";
  add(text,
      "* Line model: MA at 10 MHz, 20 m of cable, a random walk of the position, each fault "
      "alone in one of 32 cycles. A frame that is read as `biss decode` reads it.\n");
  text +=
      "* Line model: a fault does not latch, so that each one is counted; in a machine `latch` "
      "is as configured.\n";
  if (question.setup.counter.mode == CounterMode::learned) {
    text +=
        "* The range of the counter is learned in the machine; the campaign and the line model "
        "take it as 1 to 63.\n";
  }
  text +=
      "* What the documents leave open is a named parameter: `safety.md` lists them with "
      "their defaults, `configuration.json` has what was taken here.\n\n";
}

// 1 less a share that is written so.
std::string one_less(const std::string& share) {
  if (share.starts_with("0.0") && share.ends_with("e+00")) return "1";
  if (share.starts_with("1.0") && share.ends_with("e+00")) return "0";
  return "1 - " + share;
}

void add_never_committed(std::string& text, const std::vector<CoverageRow>& coverage) {
  std::vector<std::string> names;
  for (const CoverageRow& row : coverage) {
    if (row.committed == 0) names.push_back(fmt::format("`{}` ({})", row.fault, row.by));
  }
  if (names.empty()) return;
  add(text, "\n**Never committed, so that nothing is known of them:** {}.\n",
      fmt::join(names, ", "));
}

void add_coverage(std::string& text, const std::vector<CoverageRow>& coverage) {
  text +=
      "## Diagnostic coverage, as measured\n"
      "DC is 1 - accepted wrong / committed: the share of the **modelled** instances of a fault "
      "after which no wrong position was called `safe`; in sequences, no frame at all that must "
      "not "
      "be. It is not the diagnostic coverage of "
      "IEC 61508, which weighs the real failures of a real device. `at least` is the limit "
      "that holds with 95 % (two-sided). All columns are in `coverage.csv`.\n\n"
      "| kind | counted by | fault | committed | accepted wrong | DC at least | by theory |\n"
      "|---|---|---|---:|---:|---:|---:|\n";
  for (const CoverageRow& row : coverage) {
    if (row.committed == 0) continue;
    add(text, "| {} | {} | `{}` | {} | {} | {} | {} |\n", row.kind, row.by, row.fault,
        row.committed, row.accepted_wrong,
        row.accepted_wrong == row.committed ? "0: never seen"
                                            : one_less(fmt::format("{:.2e}", row.high)),
        row.theory ? one_less(fmt::format("{:.3e}", *row.theory)) : "");
  }
  add_never_committed(text, coverage);
  text +=
      "\nBy importance sampling (`flips:RATE:DRAWN`, `flips:RATE:fitting`) frames are drawn "
      "otherwise and "
      "weighed: there accepted wrong / committed is not the share.\n";
}

}  // namespace

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
  static const std::regex link("\\[([^\\]]*)\\]\\((?!safety\\.md|safety-matrix\\.md)[^)]*\\)");
  return std::regex_replace(std::string(page), link, "$1");
}

EvidenceFile evidence_readme(const EvidenceQuestion& question,
                             const std::vector<CoverageRow>& coverage,
                             const std::vector<std::string>& findings) {
  std::string text = fmt::format("# BiSS Safety: evidence for {}\n\n", question.options.format);
  text += "Made by `biss safety evidence`. A channel model, not a certificate.\n\n";
  const std::vector<std::string> missing = not_run(question.options);
  for (const std::string& each : missing) add(text, "**Nothing was run: {}.**\n\n", each);
  if (findings.empty()) {
    add(text,
        "{}o count is more than five standard deviations from its theory, no undamaged frame was "
        "called a fault, and no fault was told late or under a name that it cannot have.\n\n",
        missing.empty() ? "N" : "In the rest n");
  } else {
    text += "**Findings:**\n";
    for (const std::string& finding : findings) add(text, "* {}\n", finding);
    text += '\n';
  }
  add_files(text, question);
  add_configuration(text, question);
  add_unchecked(text, question);
  add_assumptions(text, question);
  add_coverage(text, coverage);
  return {"README.md", std::move(text)};
}

}  // namespace biss::cli
