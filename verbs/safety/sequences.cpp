// biss safety sequences: run the monitor on long sequences of frames, undamaged and with the eight
// transmission errors.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lab/sequence.hpp"
#include "lab/sequence_block.hpp"
#include "verbs/common/terminal.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/safety/experiments.hpp"
#include "verbs/safety/safety.hpp"
#include "verbs/safety/sequence_table.hpp"

namespace biss::verbs {
namespace {

struct SequenceOptions {
  std::string format;
  std::uint64_t frames = 10'000'000;
  std::uint64_t faults = 100'000;
  std::vector<std::string> kinds;
  std::vector<std::string> motions;
  std::string variant;
  std::string counter;
  std::string encoder_counter;
  std::uint64_t seed = 1;
  unsigned threads = 0;
  std::optional<std::uint64_t> replay;
  report::Format to = report::Format::table;
  std::string output;
};

using Counters = lab::SequencePlan::Counters;

std::vector<std::string> run_names() {
  std::vector<std::string> names{"undamaged", "counter_mode"};
  for (const SafetyMeasure& measure : safety_measures) names.emplace_back(name_of(measure.error));
  return names;
}

std::vector<std::string> motion_names() {
  return {lab::sequence_motion_names.begin(), lab::sequence_motion_names.end()};
}

std::vector<std::string> counter_names(bool with_learned) {
  std::vector<std::string> names;
  for (const CounterMode mode : {CounterMode::count_1_63, CounterMode::count_0_63}) {
    names.emplace_back(lab::name_of(mode));
  }
  if (with_learned) names.emplace_back(lab::name_of(CounterMode::learned));
  return names;
}

std::optional<CounterMode> mode_of(const std::string& name) {
  using enum CounterMode;
  for (const CounterMode mode : {count_1_63, count_0_63, learned}) {
    if (lab::name_of(mode) == name) return mode;
  }
  return std::nullopt;
}

// All pairs that the two options permit.
std::vector<Counters> counters_of(const SequenceOptions& options) {
  using enum CounterMode;
  const auto monitor = mode_of(options.counter);
  const auto encoder = mode_of(options.encoder_counter);
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

// The pair for injected faults: as given, else both as set up.
Counters fault_counters(const SequenceOptions& options, CounterMode usual) {
  const auto monitor = mode_of(options.counter);
  const auto encoder = mode_of(options.encoder_counter);
  const CounterMode expected = monitor.value_or(encoder.value_or(usual));
  const bool open = expected == CounterMode::learned;
  return {expected, encoder.value_or(open ? CounterMode::count_1_63 : expected)};
}

std::optional<lab::SequencePlan> basis_of(const SequenceOptions& options) {
  const auto known = parse_safety_format(options.format);
  if (!known) return std::nullopt;
  return lab::SequencePlan{.format = known->format, .setup = known->setup, .seed = options.seed};
}

ExitStatus bad_format(const std::string& name, Host& host) {
  return host.fail(ExitStatus::usage, safety_format_error(name));
}

void add_rows(const SequenceOptions& options, lab::SequencePlan& plan) {
  const auto wants = [&options](std::string_view name) {
    return options.kinds.empty() ||
           std::find(options.kinds.begin(), options.kinds.end(), name) != options.kinds.end();
  };
  for (const std::string& name : options.motions) {
    const auto at = std::find(lab::sequence_motion_names.begin(), lab::sequence_motion_names.end(),
                              std::string_view(name));
    const auto motion = static_cast<lab::SequenceMotion>(at - lab::sequence_motion_names.begin());
    for (const Counters& pair : counters_of(options)) {
      if (wants("undamaged") && !pair.differ()) plan.add_undamaged(motion, pair, options.frames);
    }
  }
  for (const Counters& pair : counters_of(options)) {
    if (wants("counter_mode") && pair.differ()) plan.add_counter_mode(pair, options.faults);
  }
  const Counters pair = fault_counters(options, plan.setup.counter.mode);
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
}

std::vector<report::Column> step_columns() {
  using report::Kind;
  return {{.name = "index", .kind = Kind::unsigned_integer},
          {.name = "time_ns", .kind = Kind::nanoseconds},
          {.name = "what"},
          {.name = "position", .kind = Kind::unsigned_integer},
          {.name = "lc", .kind = Kind::unsigned_integer},
          {.name = "bits", .kind = Kind::bits},
          {.name = "verdict"},
          {.name = "lc_read", .kind = Kind::unsigned_integer},
          {.name = "position_read", .kind = Kind::unsigned_integer}};
}

bool write_step(report::TableWriter& table, const lab::SequenceStep& step) {
  using report::Cell;
  const Cell cells[] = {step.index,
                        step.time,
                        step.what,
                        step.meant ? Cell(step.meant->cpw) : Cell(),
                        step.meant ? Cell(unsigned{step.meant->life_counter}) : Cell(),
                        step.bits.empty() ? Cell() : Cell(step.bits),
                        name_of(step.judgement.verdict),
                        unsigned{step.judgement.life_counter},
                        Cell(step.position_read)};
  return table.row(cells);
}

ExitStatus run_replay(const lab::SequencePlan& plan, const SequenceOptions& options, Host& host) {
  const std::uint64_t index = *options.replay;
  if (plan.rows.size() != 1 || index >= plan.rows[0].size) {
    return host.fail(
        ExitStatus::usage,
        "--replay needs a single row and an index in it: one --kind with its --variant, or "
        "undamaged with --motion, --counter and --encoder-counter");
  }
  const lab::SequenceRow& row = plan.rows[0];
  const auto frame =
      lab::SequenceFrame::make(plan.format, plan.setup_of(row), row.counter, row.encoder_counter);
  if (!frame) return bad_format(options.format, host);
  Output output(host);
  if (!output.open(options.output)) return output.status();
  const auto table =
      report::make_table_writer(options.to, step_columns(), output, output.table_options());
  // The frames before an undamaged frame are shown too.
  const std::uint64_t before = row.task == lab::SequenceTask::undamaged ? 4 : 0;
  bool written = true;
  count_sequence(*frame, row, plan.seed, row.blocks().block_of(index),
                 [&](const lab::SequenceStep& step) {
                   if (step.index > index || step.index + before < index) return;
                   written = written && write_step(*table, step);
                 });
  if (!written || !table->finish() || !output.finish()) return output.status();
  return ExitStatus::done;
}

ExitStatus run_safety_sequences(SequenceOptions options, Host& host) {
  if (options.motions.empty()) options.motions = {"max"};
  auto plan = basis_of(options);
  if (plan) add_rows(options, *plan);
  if (plan && plan->rows.empty()) {
    return host.fail(
        ExitStatus::usage,
        "nothing to run: the --kind has no such --variant, or the monitor expects another "
        "counter than the encoder's");
  }
  if (plan && options.replay) return run_replay(*plan, options, host);
  const auto results = plan ? run_sequence_plan(*plan, options.threads, host) : std::nullopt;
  if (!results) return bad_format(options.format, host);
  Output output(host);
  if (!output.open(options.output)) return output.status();
  if (!write_sequences(*results, options.to, output, output.table_options()) || !output.finish()) {
    return output.status();
  }
  return judge_sequences(*results, host);
}

}  // namespace

std::optional<std::vector<lab::SequenceResult>> run_sequence_plan(const lab::SequencePlan& plan,
                                                                  unsigned threads, Host& host) {
  Progress line(host);
  return lab::run_sequences(plan, threads, [&line](const lab::SequenceProgress& progress) {
    if (!line.due()) return;
    line.show(fmt::format("{} of {} blocks", progress.done, progress.all));
  });
}

ExitStatus judge_sequences(std::span<const lab::SequenceResult> results, Host& host) {
  for (const lab::SequenceResult& result : results) {
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
      .one_of(motion_names());
  add_name_option(verb, "--counter", options->counter, counter_names(true),
                  "Sign-of-life counter that the monitor expects; all by default, for faults the "
                  "configuration's");
  add_name_option(
      verb, "--encoder-counter", options->encoder_counter, counter_names(false),
      "Sign-of-life counter of the encoder; both by default, for faults the same as the "
      "monitor's");
  add_count_option(verb, "--seed", into(options->seed), "Random seed; 1 by default");
  add_count_option(verb, "--threads", into(options->threads),
                   "Worker threads; by default one per core", 1024);
  add_count_option(verb, "--replay", into(options->replay),
                   "Show one event, or an undamaged frame and the four before it");
  add_to_option(verb, options->to);
  add_output_option(verb, options->output);
  return [options](Host& host) { return run_safety_sequences(*options, host); };
}

}  // namespace biss::verbs
