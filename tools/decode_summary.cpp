#include "tools/decode_summary.hpp"

#include <fmt/format.h>

#include <iterator>

#include "report/summary.hpp"
#include "tools/quantity.hpp"

namespace biss::tools {

namespace {

constexpr unsigned places = 3;

std::string time_text(std::int64_t picoseconds) {
  return text_of(Picoseconds{picoseconds}, places);
}
std::string rate_text(std::int64_t picoseconds) {
  return text_of(rate_of(Picoseconds{picoseconds}), places);
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

std::string_view how_text(decode::LineChoice how) {
  switch (how) {
    case decode::LineChoice::told:
      return "as told";
    case decode::LineChoice::by_name:
      return "by name";
    case decode::LineChoice::by_behaviour:
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

}  // namespace

std::string decode_summary(const decode::Statistics& statistics, const std::string& capture,
                           const std::string& ma, const std::string& slo, decode::LineChoice how) {
  report::Summary summary;
  summary.title(fmt::format("{}: {} request cycle{}", capture, statistics.cycles(),
                            statistics.cycles() == 1 ? "" : "s"));
  summary.entry("lines", fmt::format("MA {}, SLO {}", ma, slo), how_text(how));
  summary.entry("status", status_counts(statistics));
  summary.entry("flags", fmt::format("{} with nE = 0, {} with nW = 0", statistics.errors(),
                                     statistics.warnings()));
  add_rate(summary, "clock", statistics.period());
  add_spread(summary, "duty", statistics.duty(), percent_text);
  add_rate(summary, "rate", statistics.interval());
  add_spread(summary, "line delay", statistics.line_delay(), time_text);
  add_spread(summary, "ACK", statistics.ack(), time_text);
  return summary.text();
}

}  // namespace biss::tools
