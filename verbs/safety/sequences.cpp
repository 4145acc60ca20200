// biss safety sequences: run the monitor on long sequences of frames, undamaged and with the eight
// transmission errors.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>

#include "lab/sequence_block.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/safety/experiments.hpp"
#include "verbs/safety/safety.hpp"

namespace biss::verbs {
namespace {

struct SequenceOptions : ExperimentOptions {
  std::uint64_t frames = 10'000'000;
  std::uint64_t faults = 100'000;
  std::vector<std::string> kinds;
  std::vector<std::string> motions;
  std::string variant;
  std::string counter;
  std::string encoder_counter;
  std::optional<std::uint64_t> replay;
};

using lab::SequenceResult;
using Counters = lab::SequencePlan::Counters;

template <class Enum, class Names>
std::optional<Enum> named(const Names& names, std::string_view name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at == names.end()) return std::nullopt;
  return static_cast<Enum>(at - names.begin());
}

std::vector<std::string> run_names() {
  std::vector<std::string> names{"undamaged", "counter_mode"};
  for (const SafetyMeasure& measure : safety_measures) names.emplace_back(name_of(measure.error));
  return names;
}

// All pairs that the two options permit.
std::vector<Counters> counters_of(std::optional<CounterMode> monitor,
                                  std::optional<CounterMode> encoder) {
  using enum CounterMode;
  std::vector<Counters> pairs;
  for (const CounterMode sent : {count_1_63, count_0_63}) {
    for (const CounterMode expected : {count_1_63, count_0_63, learned}) {
      if (encoder.value_or(sent) == sent && monitor.value_or(expected) == expected) {
        pairs.push_back({expected, sent});
      }
    }
  }
  return pairs;
}

lab::SequencePlan plan_of(const SequenceOptions& options, const SafetyFormat& monitored) {
  lab::SequencePlan plan{
      .format = monitored.format, .setup = monitored.setup, .seed = options.seed};
  const auto wants = [&options](std::string_view name) {
    return options.kinds.empty() ||
           std::find(options.kinds.begin(), options.kinds.end(), name) != options.kinds.end();
  };
  const auto monitor = named<CounterMode>(counter_mode_names, options.counter);
  const auto encoder = named<CounterMode>(counter_mode_names, options.encoder_counter);
  const std::vector<Counters> counters = counters_of(monitor, encoder);
  const std::vector<std::string> full_speed{"max"};
  for (const std::string& name : options.motions.empty() ? full_speed : options.motions) {
    const auto motion = *named<lab::SequenceMotion>(lab::sequence_motion_names, name);
    for (const Counters& pair : counters) {
      if (wants("undamaged") && !pair.differ()) plan.add_undamaged(motion, pair, options.frames);
    }
  }
  for (const Counters& pair : counters) {
    if (wants("counter_mode") && pair.differ()) plan.add_counter_mode(pair, options.faults);
  }
  // Faults are injected with the counters as given, else both as set up.
  const CounterMode expected = monitor.value_or(encoder.value_or(plan.setup.counter.mode));
  const bool open = expected == CounterMode::learned;
  const Counters pair{expected, encoder.value_or(open ? CounterMode::count_1_63 : expected)};
  for (const SafetyMeasure& measure : safety_measures) {
    // A monitor that expects another range never stays safe.
    if (wants(name_of(measure.error)) && !pair.differ()) {
      plan.add_fault(measure.error, pair, options.faults);
    }
  }
  if (!options.variant.empty()) {
    std::erase_if(plan.rows, [&options](const lab::SequenceRow& row) {
      return row.variant_name() != options.variant;
    });
  }
  return plan;
}

FieldRow fields_of(const lab::SequenceStep& step, const FrameBits& bits) {
  const auto& meant = step.meant;
  return {{"index", step.index},
          {"time_ns", step.time},
          {"what", step.what},
          {"position", meant ? std::optional(meant->cpw) : std::nullopt},
          {"lc", meant ? std::optional(meant->life_counter) : std::nullopt},
          {"bits", bits.size_bits() == 0 ? std::nullopt : std::optional(bits.view())},
          {"verdict", name_of(step.judgement.verdict)},
          {"lc_read", step.judgement.life_counter},
          {"position_read", step.position_read}};
}

ExitStatus run_replay(const lab::SequencePlan& plan, const SequenceOptions& options, Host& host) {
  const std::uint64_t index = *options.replay;
  if (plan.rows.size() != 1 || index >= plan.rows[0].size) {
    throw wrong_usage(
        "--replay needs a single row and an index in it: one --kind with its --variant, or "
        "undamaged with --motion, --counter and --encoder-counter");
  }
  const lab::SequenceRow& row = plan.rows[0];
  const auto frame =
      lab::SequenceFrame::make(plan.format, plan.setup_of(row), row.counter, row.encoder_counter);
  if (!frame) throw wrong_format(options.format);
  // The frames before an undamaged frame are shown too.
  const std::uint64_t before = row.task == lab::SequenceTask::undamaged ? 4 : 0;
  std::vector<FieldRow> steps;
  std::deque<FrameBits> kept;
  count_sequence(*frame, row, plan.seed, row.blocks().block_of(index),
                 [&](const lab::SequenceStep& step) {
                   if (step.index > index || step.index + before < index) return;
                   kept.emplace_back().append(step.bits);
                   steps.push_back(fields_of(step, kept.back()));
                 });
  return print_rows(steps, options, host);
}

// In the order of the verdicts.
std::string verdicts_of(const lab::SequenceCounts& counts) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < counts.verdicts.size(); ++k) {
    if (counts.verdicts[k] == 0) continue;
    texts.push_back(fmt::format("{}:{}", name_of(verdict_of(k)), counts.verdicts[k]));
  }
  return fmt::format("{}", fmt::join(texts, " "));
}

// CSV and JSON lines have all fields.
FieldRow fields_of(const SequenceResult& result, bool all) {
  const lab::SequenceCounts& counts = result.counts;
  const bool undamaged = result.row.task == lab::SequenceTask::undamaged;
  const auto of_event = [&](std::uint64_t value) {
    return undamaged ? std::nullopt : std::optional(value);
  };
  std::optional<std::string> theory;
  std::optional<std::string> sigma;
  if (!undamaged && result.theory) {
    theory = fmt::format("{:.4g}", static_cast<double>(*result.theory));
  }
  if (result.sigma) sigma = sigma_text(*result.sigma);
  FieldRow fields{
      {"run", result.row.name()},
      {"variant", result.row.variant_name()},
      {"counter", lab::name_of(result.row.counter)},
      {"encoder_counter", lab::name_of(result.row.encoder_counter), {.heading = "encoder"}},
      {"frames", counts.frames},
      {"false_alarms", counts.false_alarms, {.heading = "alarms"}},
      {"misread", counts.misread},
      {"events", of_event(counts.events)},
      {"accepted", of_event(counts.accepted)},
      {"theory", theory},
      {"sigma", sigma},
      {"worst_cycles", of_event(counts.worst_cycles), {.heading = "cycles"}},
      {"bound_cycles", of_event(result.bound_cycles), {.heading = "bound"}},
      {"late", of_event(counts.late)},
      {"unexpected", of_event(counts.unexpected)},
      {"result", result.passed() ? "ok" : "failed", {.role = report::Role::status}},
      {"verdicts", verdicts_of(counts)}};
  if (all) {
    fields.insert(fields.end(), {{"wrong", of_event(counts.wrong)},
                                 {"position_wraps", counts.position_wraps},
                                 {"counter_wraps", counts.counter_wraps},
                                 {"odd", fmt::format("{}", fmt::join(counts.odd, ";"))}});
  }
  return fields;
}

// Why a row has not passed, in one line: false alarms, late verdicts, ….
std::string failure_of(const SequenceResult& result) {
  std::string text = fmt::format("{} {}:", result.row.name(), result.row.variant_name());
  const lab::SequenceCounts& counts = result.counts;
  const auto add = [&text](std::uint64_t count, const char* what) {
    if (count != 0) text += fmt::format(" {} {},", count, what);
  };
  add(counts.false_alarms, "false alarms");
  add(counts.misread, "misread");
  add(counts.late, "late");
  add(counts.unexpected, "with a verdict that does not belong to the error");
  if (result.sigma && std::abs(*result.sigma) > lab::sequence_sigma_limit) {
    text += fmt::format(" {} accepted are {:+.1f} standard deviations from the theory,",
                        counts.accepted, *result.sigma);
  } else if (result.theory && *result.theory == 0 && counts.accepted != 0) {
    text += fmt::format(" {} accepted instead of 0,", counts.accepted);
  }
  text.back() = ';';
  return text + fmt::format(" the first at {}", fmt::join(counts.odd, ", "));
}

ExitStatus run_safety_sequences(const SequenceOptions& options, Host& host) {
  const lab::SequencePlan plan = plan_of(options, monitored_by(options.format));
  if (plan.rows.empty()) {
    throw wrong_usage(
        "nothing to run: the --kind has no such --variant, or the counters of monitor and encoder "
        "differ");
  }
  if (options.replay) return run_replay(plan, options, host);
  const auto results = run_sequence_plan(plan, options, host);
  const ExitStatus status = print_rows(sequence_table(results, options.to), options, host);
  return status == ExitStatus::done ? judge_sequences(results, host) : status;
}

}  // namespace

lab::SequencePlan usual_sequences(const SafetyFormat& monitored, std::uint64_t frames,
                                  std::uint64_t faults, std::uint64_t seed) {
  SequenceOptions options;
  options.seed = seed;
  options.frames = frames;
  options.faults = faults;
  return plan_of(options, monitored);
}

std::vector<lab::SequenceResult> run_sequence_plan(const lab::SequencePlan& plan,
                                                   const ExperimentOptions& options, Host& host) {
  Progress line(host);
  const auto show = [&line](const lab::SequenceProgress& progress) {
    if (!line.due()) return;
    line.show(fmt::format("{} of {} blocks", progress.done, progress.all));
  };
  auto results = lab::run_sequences(plan, options.threads, show);
  if (!results) throw wrong_format(options.format);
  return *std::move(results);
}

std::vector<FieldRow> sequence_table(std::span<const SequenceResult> results, report::Format to) {
  std::vector<FieldRow> table;
  for (const SequenceResult& each : results) {
    table.push_back(fields_of(each, to != report::Format::table));
  }
  return table;
}

ExitStatus judge_sequences(std::span<const SequenceResult> results, Host& host) {
  for (const SequenceResult& result : results) {
    if (!result.passed()) return host.fail(ExitStatus::data_failed, failure_of(result));
  }
  return ExitStatus::done;
}

Run add_safety_sequences(Verb verb) {
  const auto options = std::make_shared<SequenceOptions>();
  verb.add_option("-f,--format", options->format,
                  "Safety configuration, catalogue name, frame format of a control and a safety "
                  "word, or the "
                  "configuration.json of an evidence bundle")
      .required();
  add_count_option(verb, "--frames", into(options->frames),
                   "Undamaged frames per row; 10 million by default");
  add_count_option(verb, "--faults", into(options->faults),
                   "Faults per kind, and trials of a wrong counter; 100 000 by default");
  verb.add_option(
          "--kind", options->kinds,
          "undamaged, counter_mode, or one of the eight transmission errors. May be repeated; all "
          "by default")
      .type_name("KIND")
      .one_of(run_names());
  verb.add_option("--variant", options->variant, "Inject only this variant of the fault")
      .type_name("NAME");
  verb.add_option(
          "--motion", options->motions,
          "Motion of undamaged encoders: max, steps, creep. May be repeated; max by default")
      .type_name("NAME")
      .one_of({lab::sequence_motion_names.begin(), lab::sequence_motion_names.end()});
  add_name_option(verb, "--counter", options->counter,
                  {counter_mode_names.begin(), counter_mode_names.end()},
                  "Sign-of-life counter that the monitor expects; by default all; for faults the "
                  "counter of the configuration");
  add_name_option(verb, "--encoder-counter", options->encoder_counter,
                  {counter_mode_names.begin(), counter_mode_names.begin() + 2},
                  "Sign-of-life counter of the encoder; by default both; for faults the counter of "
                  "the monitor");
  add_seed_option(verb, options->seed);
  add_threads_option(verb, options->threads);
  add_count_option(verb, "--replay", into(options->replay),
                   "Show one event, or an undamaged frame and the four before it");
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_safety_sequences(*options, host); };
}

}  // namespace biss::verbs
