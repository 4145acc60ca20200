#include "identify/protocol_lines.hpp"

#include <cmath>

namespace biss::identify {

namespace {

constexpr std::size_t busiest_lines = 8;
constexpr std::size_t changes_kept = std::size_t{1} << 14U;

// The mean of the intervals over two changes, for intervals about as long as most of the short
// ones.
double period_of_changes(const Trace& line) {
  std::vector<double> doubles;
  for (std::size_t i = 0; i + 2 < line.changes.size(); ++i) {
    doubles.push_back(length(line.changes[i], line.changes[i + 2]));
  }
  const double usual = nth_of(doubles, doubles.size() * 3 / 10);
  return mean_within(doubles, 0.6 * usual, 1.5 * usual);
}

void find_bursts(Trace& line) {
  ClockShape& clock = line.clock;
  // In periods: the level is held longer than this only between two bursts.
  constexpr double gap_share = 1.3;
  std::vector<std::size_t> ends;
  std::size_t highs = 0;
  for (std::size_t i = 0; i + 1 < line.changes.size(); ++i) {
    if (line.interval(i) <= gap_share * clock.period) continue;
    ends.push_back(i);
    highs += line.level_before(i + 1) ? 1U : 0U;
  }
  clock.pauses = !ends.empty();
  clock.idle_high = ends.empty() ? line.first_high : 2 * highs >= ends.size();
  ends.push_back(line.changes.size() - 1);
  std::vector<std::size_t> lengths;
  std::size_t begin = 0;
  for (const std::size_t end : ends) {
    Burst burst{begin, end};
    begin = end + 1;
    if (line.level_before(burst.first) != clock.idle_high) ++burst.first;
    if (burst.first >= burst.last) continue;
    if (line.level_before(burst.last + 1) != clock.idle_high) --burst.last;
    clock.bursts.push_back(burst);
    lengths.push_back(burst.pulses());
  }
  clock.usual_pulses = most_frequent(lengths);
}

double regular_share(const Trace& line, double sample) {
  const ClockShape& clock = line.clock;
  std::vector<double> active;
  for (const Burst& burst : clock.bursts) {
    for (std::size_t i = burst.first; i < burst.last; i += 2) active.push_back(line.interval(i));
  }
  const double usual = median_of(active);
  std::size_t good = 0;
  for (const Burst& burst : clock.bursts) {
    if (burst.pulses() < 4) continue;
    good += 2;
    for (std::size_t i = burst.first; i + 2 < burst.last; i += 2) {
      const double period = line.interval(i) + line.interval(i + 1);
      const bool even = std::abs(period - clock.period) <= 0.3 * clock.period + sample;
      const bool alike = std::abs(line.interval(i) - usual) <= 0.2 * clock.period + sample;
      if (even && alike) good += 2;
    }
  }
  return share(good, line.changes.size());
}

void read_clock(Trace& line, double sample) {
  if (line.changes.size() < 12) return;
  line.clock.period = period_of_changes(line);
  if (line.clock.period <= 0) return;
  find_bursts(line);
  line.clock.regular = regular_share(line, sample);
}

}  // namespace

double mean_within(const std::vector<double>& values, double least, double most) {
  double sum = 0;
  double count = 0;
  for (const double value : values) {
    if (value < least || value > most) continue;
    sum += value;
    ++count;
  }
  return count == 0 ? 0 : sum / count;
}

double share_near_median(const std::vector<double>& values, double tolerance) {
  const double middle = median_of(values);
  return share_of(values, [&](double value) { return std::abs(value - middle) <= tolerance; });
}

std::vector<Trace> moving_lines(std::span<const wire::Edge> edges, std::size_t lines,
                                double sample) {
  std::vector<Trace> traces(lines);
  std::vector<wire::Level> levels(lines, wire::Level::unknown);
  for (std::size_t i = 0; i < lines; ++i) traces[i].line = static_cast<wire::LineIndex>(i);
  for (const auto& [time, line, level] : edges) {
    if (line >= lines || level == wire::Level::unknown || level == levels[line]) continue;
    Trace& trace = traces[line];
    if (levels[line] == wire::Level::unknown) {
      trace.first_high = level == wire::Level::high;
    } else if (trace.changes.size() < changes_kept) {
      trace.changes.push_back(time);
    }
    levels[line] = level;
  }
  std::erase_if(traces, [](const Trace& trace) { return trace.changes.empty(); });
  std::stable_sort(traces.begin(), traces.end(), [](const Trace& a, const Trace& b) {
    return a.changes.size() > b.changes.size();
  });
  if (traces.size() > busiest_lines) traces.resize(busiest_lines);
  for (Trace& trace : traces) read_clock(trace, sample);
  return traces;
}

}  // namespace biss::identify
