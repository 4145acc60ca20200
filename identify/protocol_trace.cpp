#include "identify/protocol_trace.hpp"

#include <cmath>
#include <map>
#include <numeric>

namespace biss::identify {

namespace {

constexpr std::size_t busiest_lines = 8;
constexpr std::size_t changes_kept = std::size_t{1} << 14U;
// Of a period: the level is held longer than this only between two bursts.
constexpr double gap_share = 1.3;

void add(Trace& trace, bool& known, bool& high, const wire::Edge& edge) {
  if (edge.level == wire::Level::unknown) return;
  const bool level = edge.level == wire::Level::high;
  if (!known) {
    known = true;
    trace.first_high = high = level;
  } else if (level != high && trace.changes.size() < changes_kept) {
    trace.changes.push_back(edge.time);
    high = level;
  }
}

// The mean of the intervals of two changes that are about as long as most of the short ones.
double period_of_changes(const Trace& trace) {
  std::vector<double> doubles;
  for (std::size_t i = 0; i + 2 < trace.changes.size(); ++i) {
    doubles.push_back(length(trace.changes[i], trace.changes[i + 2]));
  }
  if (doubles.empty()) return 0;
  const auto low = doubles.begin() + static_cast<std::ptrdiff_t>(doubles.size() * 3 / 10);
  std::nth_element(doubles.begin(), low, doubles.end());
  const double usual = *low;
  double sum = 0;
  double count = 0;
  for (const double value : doubles) {
    if (value < 0.6 * usual || value > 1.5 * usual) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

void split(const Trace& trace, ClockShape& shape) {
  const std::size_t count = trace.changes.size();
  std::size_t highs = 0;
  std::size_t gaps = 0;
  std::vector<Burst> runs;
  std::size_t first = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const bool ends = i + 1 == count || trace.interval(i) > gap_share * shape.period;
    if (!ends) continue;
    runs.push_back({first, i});
    first = i + 1;
    if (i + 1 == count) continue;
    ++gaps;
    highs += trace.level_before(i + 1) ? 1U : 0U;
  }
  shape.pauses = gaps != 0;
  shape.idle_high = gaps == 0 ? trace.first_high : 2 * highs >= gaps;
  for (Burst run : runs) {
    if (trace.level_before(run.first) != shape.idle_high) ++run.first;
    if (run.first >= run.last) continue;
    if (trace.level_before(run.last + 1) != shape.idle_high) --run.last;
    if (run.last > run.first) shape.bursts.push_back(run);
  }
}

double regular_share(const Trace& trace, const ClockShape& shape, double sample) {
  std::vector<double> active;
  for (const Burst& burst : shape.bursts) {
    for (std::size_t i = burst.first; i < burst.last; i += 2) active.push_back(trace.interval(i));
  }
  const double usual = median_of(active);
  std::size_t good = 0;
  for (const Burst& burst : shape.bursts) {
    if (burst.pulses() < 4) continue;
    good += 2;
    for (std::size_t i = burst.first; i + 2 < burst.last; i += 2) {
      const double period = trace.interval(i) + trace.interval(i + 1);
      const bool even = std::abs(period - shape.period) <= 0.3 * shape.period + sample;
      const bool alike = std::abs(trace.interval(i) - usual) <= 0.2 * shape.period + sample;
      if (even && alike) good += 2;
    }
  }
  return static_cast<double>(good) / static_cast<double>(trace.changes.size());
}

}  // namespace

std::vector<Trace> moving_lines(std::span<const wire::Edge> edges, std::size_t lines) {
  std::vector<Trace> traces(lines);
  std::vector<char> known(lines, 0);
  std::vector<char> high(lines, 0);
  for (std::size_t i = 0; i < lines; ++i) traces[i].line = static_cast<wire::LineIndex>(i);
  for (const wire::Edge& edge : edges) {
    if (edge.line >= lines) continue;
    bool is_known = known[edge.line] != 0;
    bool is_high = high[edge.line] != 0;
    add(traces[edge.line], is_known, is_high, edge);
    known[edge.line] = is_known ? 1 : 0;
    high[edge.line] = is_high ? 1 : 0;
  }
  std::erase_if(traces, [](const Trace& trace) { return trace.changes.empty(); });
  std::stable_sort(traces.begin(), traces.end(), [](const Trace& a, const Trace& b) {
    return a.changes.size() > b.changes.size();
  });
  if (traces.size() > busiest_lines) traces.resize(busiest_lines);
  return traces;
}

Trace without_pulses(const Trace& trace, double shortest) {
  Trace kept{trace.line, trace.first_high, {}};
  for (const Picoseconds time : trace.changes) {
    if (!kept.changes.empty() && length(kept.changes.back(), time) < shortest) {
      kept.changes.pop_back();
    } else {
      kept.changes.push_back(time);
    }
  }
  return kept;
}

ClockShape clock_shape(const Trace& trace, Picoseconds sample_period) {
  ClockShape shape;
  if (trace.changes.size() < 12) return shape;
  shape.period = period_of_changes(trace);
  if (shape.period <= 0) return shape;
  split(trace, shape);
  shape.regular = regular_share(trace, shape, static_cast<double>(sample_period.count));
  return shape;
}

std::size_t usual_pulses(std::span<const Burst> bursts) {
  std::map<std::size_t, std::size_t> counts;
  for (const Burst& burst : bursts) ++counts[burst.pulses()];
  const auto most =
      std::max_element(counts.begin(), counts.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? 0 : most->first;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double share_near_median(const std::vector<double>& values, double tolerance) {
  if (values.empty()) return 0;
  const double middle = median_of(values);
  const auto near = std::count_if(values.begin(), values.end(), [&](double value) {
    return std::abs(value - middle) <= tolerance;
  });
  return static_cast<double>(near) / static_cast<double>(values.size());
}

}  // namespace biss::identify
