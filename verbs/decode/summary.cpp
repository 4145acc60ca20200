// The summary of a capture, in a few lines for a reader.
#include <fmt/format.h>

#include <optional>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "device/words.hpp"
#include "report/summary.hpp"
#include "verbs/common/identified.hpp"
#include "verbs/decode/decode_run.hpp"
#include "verbs/decode/safety.hpp"

namespace biss::verbs {

namespace {

constexpr unsigned summary_places = 3;

std::string time_text(std::int64_t picoseconds) {
  return text_of(Picoseconds{picoseconds}, summary_places);
}
std::string rate_text(std::int64_t picoseconds) {
  return text_of(rate_of(Picoseconds{picoseconds}), summary_places);
}
std::string percent_text(std::int64_t per_mille) {
  return fmt::format("{}.{} %", per_mille / 10, per_mille % 10);
}

// The longest period or interval is the lowest rate.
void add_spread(report::Summary& summary, std::string_view key, const decode::Distribution& values,
                std::string (*text)(std::int64_t value)) {
  if (values.count() == 0) return;
  std::string low = text(values.min());
  std::string high = text(values.max());
  if (text == rate_text) std::swap(low, high);
  const std::string median = text(values.median());
  const bool varies = values.min() != values.max();
  summary.entry(key, median, varies ? fmt::format("({} .. {} .. {})", low, median, high) : "");
}

std::string_view origin_text(const decode::FoundLines& found) {
  switch (found.origin) {
    case decode::LineOrigin::given:
      return "as given";
    case decode::LineOrigin::by_name:
      return found.further_pairs ? "by name; --each reads all encoders" : "by name";
    case decode::LineOrigin::by_behaviour:
      return "by behaviour";
  }
  return "";
}

std::string status_counts(const decode::Statistics& statistics) {
  std::string text;
  for (std::size_t i = 0; i < cycle_status_count; ++i) {
    const auto status = static_cast<CycleStatus>(i);
    report::append_count(text, statistics.count(status), name_of(status));
  }
  return text;
}

// In the words of `explain`. Some cycles may be good, so that the format fits and the encoder answers.
std::string usual_hint(CycleStatus status, const decode::Statistics& statistics) {
  const StatusWords& words = words_of(status);
  return std::string(statistics.good() != 0 ? words.remedy_of_some : words.remedy_of_all);
}

// An option that accepts the ACK of this capture, if there is one.
std::string ack_hint(const decode::Statistics& statistics, const DecodedCapture& capture) {
  const DeviceTiming& timing = capture.timing();
  const decode::Distribution& clocks = statistics.ack_clocks();
  const StatusWords& words = words_of(CycleStatus::ack_range);
  if (clocks.count() == 0) return std::string(words.remedy_of_all);
  // Single cycles: START was disturbed.
  if (20 * statistics.count(CycleStatus::ack_range) < statistics.good()) {
    return std::string(words.remedy_of_some);
  }
  if (clocks.min() == clocks.max()) {
    return fmt::format("does -f name this encoder? else give --ack-clocks {}", clocks.max());
  }
  const Picoseconds longest{statistics.ack().max()};
  const Picoseconds period{statistics.period().median()};
  if (longest > biss_busy_max) {
    return fmt::format("ACK takes up to {}, longer than BiSS C allows: no option accepts it",
                       text_of(longest, summary_places));
  }
  const bool long_enough = clocks.min() >= ack_bounds(timing, period).min_clocks;
  if (timing.ack_clocks == 0 && long_enough) {
    return fmt::format("does -f name this encoder? else give --ack-max {}ns",
                       (longest.count + 999) / 1000);
  }
  const auto& format = capture.format();
  return fmt::format("ACK takes {} to {} clocks: {}{}", clocks.min(), clocks.max(),
                     timing.ack_clocks != 0 ? "leave out --ack-clocks, or " : "",
                     format ? fmt::format("give -f {}", format_text(*format).view())
                            : "leave out the limits of ACK");
}

std::string response_hint(const decode::Statistics& statistics) {
  const decode::Distribution& early = statistics.early();
  // The decoder allows a quarter of a period at most.
  if (early.count() != 0 && 4 * early.max() <= statistics.period().min()) {
    return fmt::format(
        "SLO falls up to {} before the edge of ACK; in a sampled capture give --resolution {}ns",
        time_text(early.max()), (early.max() + 999) / 1000);
  }
  return usual_hint(CycleStatus::response_range, statistics);
}

// The first thing to try; docs/status.md has them all.
std::string what_to_try(CycleStatus status, const decode::Statistics& statistics,
                        const DecodedCapture& capture) {
  if (status == CycleStatus::response_range) return response_hint(statistics);
  if (status == CycleStatus::ack_range) return ack_hint(statistics, capture);
  return usual_hint(status, statistics);
}

// The most frequent cause that has a remedy.
std::optional<CycleStatus> foremost_cause(const decode::Statistics& statistics) {
  std::optional<CycleStatus> foremost;
  for (std::size_t i = 0; i < cycle_status_count; ++i) {
    const auto status = static_cast<CycleStatus>(i);
    if (!is_fault(status) || statistics.count(status) == 0) continue;
    if (!foremost || statistics.count(status) > statistics.count(*foremost)) foremost = status;
  }
  return foremost;
}

void add_marginal(report::Summary& summary, const decode::Statistics& statistics,
                  const decode::MarginSetup& margin) {
  if (statistics.margin_judged() != 0) {
    summary.entry("marginal",
                  fmt::format("{} of {}", statistics.marginal(), statistics.margin_judged()),
                  "SLO changes within 5 % of a period of the sampling point");
  } else if (margin.resolution.count != 0 && statistics.line_delay().count() != 0) {
    summary.entry("marginal", "not known",
                  fmt::format("edges are accurate to {}, 5 % of a period is {}",
                              time_text(margin.resolution.count),
                              time_text(statistics.period().median() / 20)));
  }
}

void add_lines(report::Summary& summary, const DecodedCapture& capture) {
  const decode::FoundLines& found = capture.lines();
  summary.entry("lines",
                fmt::format("MA = {}{}, SLO = {}{}", capture.ma_name(),
                            found.lines.ma_inverted ? " (inverted)" : "", capture.slo_name(),
                            found.lines.slo_inverted ? " (inverted)" : ""),
                origin_text(found));
}

std::string limit_hint(decode::Limit limit, const DeviceTiming& timing) {
  switch (limit) {
    case decode::Limit::clock_max:
      return fmt::format("{} at most: lower the clock, or give --clock-max if the encoder has more",
                         text_of(timing.clock_max));
    case decode::Limit::clock_min:
      return fmt::format("{} at least: raise the clock", text_of(timing.clock_min));
    case decode::Limit::clock_change:
      return "send all clocks of a request at one frequency and without a pause";
    case decode::Limit::cycle_min:
      return fmt::format("{} from request to request at least: lower the rate, or give --cycle-min",
                         text_of(timing.cycle_min));
    case decode::Limit::release:
      return fmt::format(
          "SLO contradicts the timeout {}: does -f name this encoder? else give --timeout",
          text_of(timing.timeout));
  }
  return "";
}

// All limits that are exceeded, and what to do about the most frequent one.
void add_limits(report::Summary& summary, const decode::Statistics& statistics,
                const DeviceTiming& timing) {
  if (statistics.limited() == 0) return;
  std::string text;
  auto foremost = decode::Limit::clock_max;
  for (std::size_t i = 0; i < decode::limit_count; ++i) {
    const auto limit = static_cast<decode::Limit>(i);
    report::append_count(text, statistics.count(limit), name_of(limit));
    if (statistics.count(limit) > statistics.count(foremost)) foremost = limit;
  }
  summary.entry("limits", text,
                fmt::format("{}: {}", name_of(foremost), limit_hint(foremost, timing)));
}

}  // namespace

std::string DecodeRun::summary() const {
  const decode::Statistics& statistics = now_.statistics;
  const bool is_log = capture_.words() != nullptr;
  report::Summary summary;
  const std::string_view noun = is_log ? "word" : "request cycle";
  summary.title(capture_.name() + ": " + report::counted(statistics.cycles(), noun));
  if (!is_log) add_lines(summary, capture_);
  summary.entry("status", status_counts(statistics));
  if (capture_.format()) {
    summary.entry("flags", fmt::format("{} with nE = 0, {} with nW = 0", statistics.errors(),
                                       statistics.warnings()));
  }
  if (const identify::FormatFinding* finding = capture_.finding()) {
    add_identified(summary, *finding, capture_.format().has_value());
  }
  if (!capture_.format()) {
    summary.entry(capture_.finding() ? "" : "format", capture_.finding() ? "used: none" : "none",
                  "only the structure is checked; give -f FORMAT for positions and flags");
  }
  add_limits(summary, statistics, capture_.timing());
  add_marginal(summary, statistics, capture_.margin());
  if (now_.safety) add_safety(summary, *now_.safety, now_.safety_name);
  add_spread(summary, "clock", statistics.period(), rate_text);
  add_spread(summary, "duty", statistics.duty(), percent_text);
  if (capture_.timed()) add_spread(summary, "rate", statistics.interval(), rate_text);
  add_spread(summary, "line delay", statistics.line_delay(), time_text);
  add_spread(summary, "ACK", statistics.ack(), time_text);
  const std::string fitting = is_log && !capture_.words()->next && capture_.format()
                                  ? capture_.fitting_options()
                                  : std::string();
  if (!fitting.empty()) {
    summary.entry("try", "words", fitting);
  } else if (!is_log && capture_.lines().look_swapped) {
    summary.entry("try", "swapped?", remedy_of(Cause::ma_slo_swapped));
  } else if (const auto cause = foremost_cause(statistics)) {
    summary.entry("try", name_of(*cause), what_to_try(*cause, statistics, capture_));
  }
  return summary.text();
}

}  // namespace biss::verbs
