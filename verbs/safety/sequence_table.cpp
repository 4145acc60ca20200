// The table of safety sequences.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "verbs/common/host.hpp"
#include "verbs/safety/experiments.hpp"

namespace biss::verbs {
namespace {

using lab::SequenceResult;

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

}  // namespace

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

}  // namespace biss::verbs
