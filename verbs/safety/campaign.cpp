// biss safety campaign: inject faults into frames and count undetected errors, with the exact theory.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <atomic>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <memory>

#include "archive/hash.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/text_file.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/safety/experiments.hpp"
#include "verbs/safety/safety.hpp"

namespace biss::verbs {
namespace {

constexpr const char* measured_faults =
    "flips:RATE[:DRAWN|:fitting] (up to 0.5), burst:BITS[:PLACE] (2 to 32), "
    "gap_low:BITS[:PLACE], gap_high:BITS[:PLACE] (1 to 32)";
constexpr const char* placed_faults =
    "lost_bit, doubled_bit, slo_low, slo_high, inserted_low, inserted_high, false_start";
constexpr const char* other_faults = "lost_start, cds_high, stop_high";

constexpr auto usual_faults = std::to_array<const char*>(
    {"flips:0.5", "flips:0.1", "flips:0.01", "burst:16", "burst:32", "lost_bit", "doubled_bit",
     "slo_low", "slo_high", "inserted_low", "inserted_high", "gap_low:8", "gap_high:8",
     "lost_start", "false_start", "cds_high", "stop_high"});

struct CampaignOptions : ExperimentOptions {
  std::uint64_t frames = 10'000'000;
  std::vector<std::string> faults{usual_faults.begin(), usual_faults.end()};
  lab::Shard shard;
  std::string state;
  Picoseconds save_every = milliseconds(5000);
  bool plain = false;
  std::optional<std::uint64_t> replay;
  std::vector<std::string> parts;
  std::optional<Verb> merge;
};

std::optional<lab::CampaignFrame> frame_of(const std::string& format) {
  const auto known = parse_safety_format(format);
  if (!known) return std::nullopt;
  return lab::CampaignFrame::make(known->format, known->setup);
}

// The settings of the monitor that change the counts, for CampaignPlan::rules.
std::string rules_of(const lab::CampaignFrame& frame) {
  const auto& alignment = frame.plan().alignment();
  return fmt::format("compared bits {}, of them turns {}, tolerance {}, counter from {}",
                     alignment.bits, alignment.bits - alignment.singleturn_bits,
                     frame.plan().setup().comparison.tolerance_lsb, frame.first_counter());
}

// Adds rows by importance sampling for events that are too rare for plain sampling. They are part of
// the plan, so every shard has them.
void add_importance(const lab::CampaignFrame& frame, lab::CampaignPlan& plan) {
  const std::vector<lab::FaultChoice> asked = plan.faults;
  lab::CampaignTheories theories(frame);
  for (const lab::FaultChoice& fault : asked) {
    if (fault.kind != lab::FaultKind::flips) continue;
    const auto theory = theories.of(fault);
    if (!theory) continue;
    const auto weighed = lab::importance_of(frame, fault, plan.frames, *theory);
    plan.faults.insert(plan.faults.end(), weighed.begin(), weighed.end());
  }
}

lab::CampaignState read_state_of(const std::string& path) {
  const auto file = read_text_file(path);
  if (!file) throw wrong_file("{}: {}", path, file.error());
  auto state = lab::read_state(*file);
  if (!state || !archive::checksum_holds(*file)) {
    throw wrong_file("{}: not a usable campaign state: {}", path,
                     state ? archive::checksum_wrong : state.error());
  }
  return *std::move(state);
}

void check_fit(const lab::CampaignFrame& frame, const lab::CampaignState& state,
               const std::string& path) {
  if (fits(frame, state)) return;
  throw wrong_file("{}: not a usable campaign state: more wrong bits than the words have", path);
}

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

ExitStatus print_state(const lab::CampaignFrame& frame, const lab::CampaignState& state,
                       const CampaignOptions& options, Host& host) {
  const std::vector<CampaignRow> rows = campaign_rows(frame, state);
  const ExitStatus status = print_rows(campaign_table(rows, options.to), options, host);
  return status == ExitStatus::done ? judge_campaign(rows, host) : status;
}

bool save(const lab::CampaignState& state, const std::string& path, Host& host) {
  if (path.empty()) return true;
  Output file(host);
  std::string text = lab::state_text(state);
  text.resize(text.rfind('}'));
  text += archive::checksum_end(archive::hash_of(text));
  const bool saved = file.open(path) && file.write(text) && file.finish();
  if (!saved) host.warn(file.error());
  return saved;
}

constexpr std::array<int, 3> signal_numbers{SIGINT, SIGTERM, SIGHUP};
using Handler = void (*)(int);

std::array<Handler, signal_numbers.size()> previous_handlers{};
std::atomic<int> noted_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

void restore_handlers() {
  for (std::size_t n = 0; n < signal_numbers.size(); ++n)
    std::signal(signal_numbers[n], previous_handlers[n]);
}

extern "C" void note_signal(int number) {
  noted_signal = number;
  restore_handlers();
}

// The user's signal to end a long run: the run saves its results before the process ends. While it
// exists, the first SIGINT, SIGTERM or SIGHUP is only noted. A second one ends the process as it does
// without this. A signal that the parent process ignores stays ignored. \pre at most one exists at a
// time
class Interruption {
 public:
  Interruption() {
    noted_signal = 0;
    for (std::size_t n = 0; n < signal_numbers.size(); ++n) {
      previous_handlers[n] = std::signal(signal_numbers[n], SIG_IGN);
    }
    for (std::size_t n = 0; n < signal_numbers.size(); ++n) {
      if (previous_handlers[n] != SIG_IGN) std::signal(signal_numbers[n], note_signal);
    }
  }
  ~Interruption() { restore_handlers(); }
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  bool requested() const { return noted_signal != 0; }
  // Ends the process by the signal that was noted. \pre requested()
  void end_process() const { std::raise(noted_signal); }
};

// With a state file, a signal ends the run after a last save.
ExitStatus count_blocks(const lab::CampaignFrame& frame, lab::CampaignState& state,
                        const CampaignOptions& options, Host& host) {
  std::optional<Interruption> interruption;
  if (!options.state.empty()) interruption.emplace();
  lab::ExperimentRun run{.threads = options.threads,
                         .shard = options.shard,
                         .save_seconds = static_cast<double>(options.save_every.count) * 1e-12};
  run.save = [&] { return save(state, options.state, host); };
  Progress progress(host);
  const std::uint64_t before = state.frames_done();
  run.interrupted = [&] {
    if (progress.due()) {
      const std::uint64_t done = state.frames_done();
      progress.show(progress_text({.done = done, .all = state.frames_planned(), .before = before},
                                  "frames", progress.seconds()));
    }
    return interruption && interruption->requested();
  };
  if (run_campaign(frame, state, run)) return ExitStatus::done;
  if (interruption && interruption->requested()) {
    host.warn(fmt::format("interrupted after {} of {} frames; the same command continues from {}",
                          state.frames_done(), state.frames_planned(), options.state));
    interruption->end_process();
  }
  return ExitStatus::io;
}

ExitStatus run_counts(const lab::CampaignFrame& frame, lab::CampaignPlan plan,
                      const CampaignOptions& options, Host& host) {
  if (!options.plain) add_importance(frame, plan);
  lab::CampaignState state(plan);
  if (!options.state.empty() && std::filesystem::exists(options.state)) {
    state = read_state_of(options.state);
    if (state.plan != plan) {
      throw wrong_file(
          "{}: state of another campaign (format, faults, frames or seed differ); give another "
          "file",
          options.state);
    }
    check_fit(frame, state, options.state);
  }
  const ExitStatus status = count_blocks(frame, state, options, host);
  return status == ExitStatus::done ? print_state(frame, state, options, host) : status;
}

ExitStatus run_replay(const lab::CampaignFrame& frame, const lab::CampaignPlan& plan,
                      const CampaignOptions& options, Host& host) {
  if (plan.faults.size() != 1) {
    throw wrong_usage("--replay needs exactly one --fault");
  }
  const std::uint64_t index = *options.replay;
  if (plan.faults[0].fitting && index >= lab::max_fitting_frames) {
    throw wrong_usage("--replay {}: a fitting draw has {} frames at most", index,
                      lab::max_fitting_frames);
  }
  if (index >= plan.frames) {
    host.warn(
        fmt::format("frame {} is not below the {} of --frames; shown as a longer campaign draws it",
                    index, plan.frames));
  }
  const lab::ReplayedFrame replayed = lab::replay_frame(frame, {plan.faults[0], plan.seed}, index);
  const SafetyJudgement judgement = frame.monitor(replayed.sent, replayed.received);
  const lab::WordPair read = frame.read(replayed.received).value_or(lab::WordPair());
  const auto hex = [](std::uint64_t bits) { return fmt::format("0x{:X}", bits); };
  std::optional<std::uint64_t> position;
  if (judgement.position) position = control_position(frame.plan(), *judgement.position);
  const FieldRow fields{{"fault", text_of(plan.faults[0])},      {"frame", index},
                        {"position", replayed.sent.position},    {"lc", replayed.sent.life_counter},
                        {"cpw_sent", hex(replayed.encoded.cpw)}, {"cpw_read", hex(read.cpw)},
                        {"spw_sent", hex(replayed.encoded.spw)}, {"spw_read", hex(read.spw)},
                        {"verdict", name_of(judgement.verdict)}, {"position_read", position}};
  return print_rows({fields}, options, host);
}

ExitStatus run_merge(const CampaignOptions& options, Host& host) {
  std::optional<lab::CampaignState> sum;
  for (const std::string& path : options.parts) {
    lab::CampaignState part = read_state_of(path);
    const auto frame = frame_of(part.plan.format);
    if (!frame || rules_of(*frame) != part.plan.rules) {
      throw wrong_file("{}: made with monitor rules that this program does not have", path);
    }
    check_fit(*frame, part, path);
    if (!sum) {
      sum = std::move(part);
    } else if (!sum->merge(part)) {
      throw wrong_file("{}: state of another campaign, or with blocks that an earlier file has too",
                       path);
    }
  }
  const auto frame = frame_of(sum->plan.format);
  if (!options.state.empty() && !save(*sum, options.state, host)) return ExitStatus::io;
  const ExitStatus status = print_state(*frame, *sum, options, host);
  if (status != ExitStatus::done || sum->complete()) return status;
  return host.fail(ExitStatus::data_failed,
                   "parts are missing: the table does not cover the whole campaign");
}

lab::CampaignPlan plan_of(const lab::CampaignFrame& frame, const CampaignOptions& options) {
  lab::CampaignPlan plan{.format = options.format,
                         .rules = rules_of(frame),
                         .seed = options.seed,
                         .frames = options.frames,
                         .faults = {}};
  for (const std::string& text : options.faults) {
    const auto fault = lab::parse_fault(text);
    if (!fault || fault->place.value_or(0) >= lab::places_of(*fault, frame.bits())) {
      throw wrong_usage(
          "'{}' is not a fault of these {} bits: {}, or one of {} with [:PLACE], or {}", text,
          frame.bits(), measured_faults, placed_faults, other_faults);
    }
    plan.faults.push_back(*fault);
  }
  return plan;
}

ExitStatus run_safety_campaign(const CampaignOptions& options, Host& host) {
  if (options.merge->parsed()) return run_merge(options, host);
  if (options.format.empty()) throw wrong_usage("no --format given");
  const auto frame = frame_of(options.format);
  if (!frame) throw wrong_format(options.format);
  const lab::CampaignPlan plan = plan_of(*frame, options);
  return options.replay ? run_replay(*frame, plan, options, host)
                        : run_counts(*frame, plan, options, host);
}

}  // namespace

lab::CampaignState run_usual_campaign(const lab::CampaignFrame& frame, std::uint64_t frames,
                                      const ExperimentOptions& options, Host& host) {
  CampaignOptions campaign;
  static_cast<ExperimentOptions&>(campaign) = options;
  campaign.frames = frames;
  lab::CampaignPlan plan = plan_of(frame, campaign);
  add_importance(frame, plan);
  lab::CampaignState state(plan);
  count_blocks(frame, state, campaign, host);
  return state;
}

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

Run add_safety_campaign(Verb verb) {
  const auto options = std::make_shared<CampaignOptions>();
  verb.add_option(
      "-f,--format", options->format,
      "Safety configuration, catalogue name, frame format of a control and a safety word, or the "
      "configuration.json of an evidence bundle");
  verb.add_option("--fault", options->faults,
                  fmt::format("Fault to inject: {}; {}, each with [:PLACE]; {}. May be repeated; "
                              "all kinds by default",
                              measured_faults, placed_faults, other_faults))
      .type_name("KIND");
  add_count_option(verb, "--frames", into(options->frames),
                   "Frames per fault; 10 million by default", lab::max_campaign_frames);
  add_seed_option(verb, options->seed);
  add_threads_option(verb, options->threads);
  add_shard_option(verb, options->shard, "Count only the K-th of N parts");
  verb.add_option("--state", options->state, "Save progress to this file, and continue from it")
      .file(FileUse::read_and_write);
  add_duration_option(verb, "--save-every", into(options->save_every),
                      "Time between two saves of --state; 5 s by default");
  verb.add_flag("--no-importance", options->plain,
                "Omit the rows by importance sampling, which are for rare events");
  add_count_option(verb, "--replay", into(options->replay),
                   "Show one frame of a single --fault, for example one listed as missed",
                   lab::max_campaign_frames - 1);
  Verb merge = verb.add_verb(
      {.name = "merge", .purpose = "Add up the states of several shards", .examples = {}});
  merge.add_option("FILE", options->parts, "State files written by --state")
      .required()
      .file(FileUse::read);
  merge.add_option("--state", options->state, "Write the sum to this file").file(FileUse::write);
  for (const Verb& each : {verb, merge}) {
    add_to_option(each, options->to);
    add_output_option(each, options->output);
  }
  options->merge = merge;
  return [options](Host& host) { return run_safety_campaign(*options, host); };
}

}  // namespace biss::verbs
