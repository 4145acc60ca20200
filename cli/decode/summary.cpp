#include "cli/decode/summary.hpp"

#include <fmt/format.h>

#include <iterator>
#include <optional>

#include "biss/frame/format_text.hpp"
#include "cli/common/identified.hpp"
#include "cli/decode/safety.hpp"
#include "device/quantity.hpp"
#include "explain/cause.hpp"
#include "report/summary.hpp"

namespace biss::cli {

namespace {

using decode::CycleStatus;
using explain::Cause;

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

template <class Text>
void add_spread(report::Summary& summary, std::string_view key, const decode::Distribution& values,
                Text text) {
  if (values.count() == 0) return;
  const std::string median = text(values.median());
  if (values.min() == values.max()) {
    summary.entry(key, median);
    return;
  }
  summary.entry(key, median, report::spread(text(values.min()), median, text(values.max())));
}

// Of a period or an interval the longest is the lowest rate.
void add_rate(report::Summary& summary, std::string_view key, const decode::Distribution& periods) {
  if (periods.count() == 0) return;
  const std::string median = rate_text(periods.median());
  if (periods.min() == periods.max()) {
    summary.entry(key, median);
    return;
  }
  summary.entry(key, median,
                report::spread(rate_text(periods.max()), median, rate_text(periods.min())));
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
  for (std::size_t i = 0; i < decode::cycle_status_count; ++i) {
    const auto status = static_cast<decode::CycleStatus>(i);
    if (statistics.count(status) == 0) continue;
    fmt::format_to(std::back_inserter(text), "{}{} {}", text.empty() ? "" : ", ",
                   statistics.count(status), name_of(status));
  }
  return text;
}

std::string remedy_words(Cause cause) { return std::string(remedy_of(cause)); }

// Some cycles are good, so that the format fits and the encoder answers.
bool works_at_times(const decode::Statistics& statistics) { return statistics.good() != 0; }

// An option that accepts the ACK of this capture, where there is one.
std::string ack_hint(const decode::Statistics& statistics, const DecodedCapture& capture) {
  const DeviceTiming& timing = capture.timing();
  const decode::Distribution& clocks = statistics.ack_clocks();
  if (clocks.count() == 0) return remedy_words(Cause::wrong_format);
  // Single cycles: START was disturbed.
  if (20 * statistics.count(CycleStatus::ack_range) < statistics.good()) {
    return remedy_words(Cause::noise_on_slo);
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
  return remedy_words(works_at_times(statistics) ? Cause::requested_too_soon : Cause::not_biss);
}

// The first thing to try, in the words of `explain`; docs/status.md has them all.
std::string what_to_try(CycleStatus cause, const decode::Statistics& statistics,
                        const DecodedCapture& capture) {
  const bool at_times = works_at_times(statistics);
  switch (cause) {
    case CycleStatus::no_response:
      return remedy_words(at_times ? Cause::supply_or_intermittent : Cause::no_encoder);
    case CycleStatus::not_ready:
      return remedy_words(at_times ? Cause::requested_too_soon : Cause::stuck_low);
    case CycleStatus::response_range:
      return response_hint(statistics);
    case CycleStatus::no_start:
      return remedy_words(Cause::ack_longer_than_master_waits);
    case CycleStatus::ack_range:
      return ack_hint(statistics, capture);
    case CycleStatus::truncated:
      return at_times ? remedy_words(Cause::master_stops_early)
                      : "a format with fewer bits, or more clocks from the master";
    case CycleStatus::cds:
      return "leave ;cds0 out of the format if the master uses registers";
    case CycleStatus::crc:
    case CycleStatus::stop_bit:
      return remedy_words(at_times ? Cause::noise_on_slo : Cause::wrong_format);
    case CycleStatus::ma_glitch:
      return remedy_words(Cause::noise_on_ma);
    case CycleStatus::ma_clock:
      return remedy_words(at_times ? Cause::noise_on_ma : Cause::sampling_too_slow);
    case CycleStatus::unknown_level:
      return "x or z on a line (reset, two drivers), or a capture or a file of one line that ended "
             "there";
    case CycleStatus::ok:
    case CycleStatus::unchecked:
    case CycleStatus::cut_start:
    case CycleStatus::cut_end:
      break;
  }
  return "";
}

bool is_fault(CycleStatus status) {
  return !is_good(status) && status != CycleStatus::cut_start && status != CycleStatus::cut_end;
}

// The most frequent cause that something can be done about.
std::optional<CycleStatus> foremost_cause(const decode::Statistics& statistics) {
  std::optional<CycleStatus> foremost;
  for (std::size_t i = 0; i < decode::cycle_status_count; ++i) {
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
                  fmt::format("edges are known to {}, 5 % of a period is {}",
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
          "SLO does not keep the timeout {}: does -f name this encoder? else --timeout",
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
    const std::uint64_t count = statistics.count(limit);
    if (count == 0) continue;
    fmt::format_to(std::back_inserter(text), "{}{} {}", text.empty() ? "" : ", ", count,
                   name_of(limit));
    if (count > statistics.count(foremost)) foremost = limit;
  }
  summary.entry("limits", text,
                fmt::format("{}: {}", name_of(foremost), limit_hint(foremost, timing)));
}

}  // namespace

std::string decode_summary(const decode::Statistics& statistics, const DecodedCapture& capture,
                           const decode::SafetyWatch* safety, std::string_view safety_name) {
  const bool is_log = capture.words() != nullptr;
  report::Summary summary;
  summary.title(fmt::format("{}: {} {}{}", capture.name(), statistics.cycles(),
                            is_log ? "word" : "request cycle",
                            statistics.cycles() == 1 ? "" : "s"));
  if (!is_log) add_lines(summary, capture);
  summary.entry("status", status_counts(statistics));
  if (capture.format()) {
    summary.entry("flags", fmt::format("{} with nE = 0, {} with nW = 0", statistics.errors(),
                                       statistics.warnings()));
  }
  if (const identify::FormatFinding* finding = capture.finding()) {
    add_identified(summary, *finding, capture.format().has_value());
  }
  if (!capture.format()) {
    summary.entry(capture.finding() ? "" : "format", capture.finding() ? "used: none" : "none",
                  "only the structure is checked; give -f FORMAT for positions and flags");
  }
  add_limits(summary, statistics, capture.timing());
  add_marginal(summary, statistics, capture.margin());
  if (safety != nullptr) add_safety(summary, *safety, safety_name);
  add_rate(summary, "clock", statistics.period());
  add_spread(summary, "duty", statistics.duty(), percent_text);
  if (capture.timed()) add_rate(summary, "rate", statistics.interval());
  add_spread(summary, "line delay", statistics.line_delay(), time_text);
  add_spread(summary, "ACK", statistics.ack(), time_text);
  const std::string fitting =
      is_log && capture.format() ? capture.fitting_options() : std::string();
  if (!fitting.empty()) {
    summary.entry("try", "words", fitting);
  } else if (!is_log && capture.lines().look_swapped) {
    summary.entry("try", "swapped?", remedy_of(Cause::ma_slo_swapped));
  } else if (const auto cause = foremost_cause(statistics)) {
    summary.entry("try", name_of(*cause), what_to_try(*cause, statistics, capture));
  }
  return summary.text();
}

}  // namespace biss::cli
