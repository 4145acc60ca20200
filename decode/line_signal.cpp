#include "decode/line_signal.hpp"

#include <algorithm>

#include "decode/times.hpp"

namespace biss::decode {

namespace {

using wire::Level;

bool certainly_shorter(Picoseconds level, Picoseconds than, Picoseconds resolution) {
  return level + resolution < than;
}

// Consecutive short levels are one pulse. The levels before and after it are the rest of the level
// that the pulse interrupts.
void measure_ma(const SignalSpan& span, LineSignal& signal) {
  Picoseconds shortest = signal.pulse_max;
  if (span.ma.size() > 1) shortest = elapsed(span.ma[0].time, span.ma[1].time);
  for (std::size_t i = 2; i < span.ma.size(); ++i) {
    shortest = std::min(shortest, elapsed(span.ma[i - 1].time, span.ma[i].time));
  }
  // Nearly always there is no pulse.
  if (!certainly_shorter(shortest, signal.pulse_max, span.resolution)) {
    if (span.ma.size() > 1) signal.ma_shortest = shortest;
    return;
  }
  bool after_pulse = false;
  std::optional<Picoseconds> last;
  for (std::size_t i = 1; i < span.ma.size(); ++i) {
    const Picoseconds level = elapsed(span.ma[i - 1].time, span.ma[i].time);
    const bool is_short = certainly_shorter(level, signal.pulse_max, span.resolution);
    if (is_short && !after_pulse) ++signal.ma_pulses;
    if (!is_short && last) signal.ma_shortest = std::min(signal.ma_shortest.value_or(*last), *last);
    last = is_short || after_pulse ? std::nullopt : std::optional(level);
    after_pulse = is_short;
  }
  if (last) signal.ma_shortest = std::min(signal.ma_shortest.value_or(*last), *last);
}

std::size_t end_of_slo(const SignalSpan& span, const LineHistory& slo) {
  return std::min(span.slo_end, slo.after(span.limit));
}

void count_slo_pulses(const SignalSpan& span, const LineHistory& slo, LineSignal& signal) {
  const std::size_t end = end_of_slo(span, slo);
  bool after_pulse = false;
  for (std::size_t i = slo.after(span.ma.front().time) + 1; i < end; ++i) {
    const bool known = slo[i].level != Level::unknown && slo[i - 1].level != Level::unknown;
    const bool is_short = known && certainly_shorter(elapsed(slo[i - 1].time, slo[i].time),
                                                     signal.pulse_max, span.resolution);
    if (is_short && !after_pulse) ++signal.slo_pulses;
    after_pulse = is_short;
  }
}

void measure_ready(const SignalSpan& span, const LineHistory& slo, LineSignal& signal) {
  const Picoseconds begin = span.ma.front().time;
  std::size_t i = slo.after(begin);
  const Level level = slo.level_before(i);
  if (level == Level::high) {
    const auto rise = slo.taken_at(i);
    if (rise) signal.ready = elapsed(*rise, begin);
  } else if (level == Level::low) {
    const std::size_t end = end_of_slo(span, slo);
    while (i < end && slo[i].level != Level::high) ++i;
    signal.ready = -elapsed(begin, i < end ? slo[i].time : std::max(begin, span.limit));
  }
}

bool is_in_pulse(const LineHistory& slo, std::size_t i, std::size_t end, Picoseconds pulse_max) {
  const bool ends = i != 0 && elapsed(slo[i - 1].time, slo[i].time) < pulse_max;
  return ends || (i + 1 < end && elapsed(slo[i].time, slo[i + 1].time) < pulse_max);
}

}  // namespace

LineSignal measure_signal(const SignalSpan& span, const LineHistory& slo) {
  LineSignal signal;
  const std::uint32_t high = std::min(span.duty_per_mille, 1000U);
  const std::int64_t shorter = std::min(high, 1000U - high);
  signal.pulse_max = span.period * shorter / 2000;
  measure_ma(span, signal);
  count_slo_pulses(span, slo, signal);
  measure_ready(span, slo, signal);
  return signal;
}

LineSignal::Changes measure_changes(std::span<const Picoseconds> rises, const LineHistory& slo,
                                    std::size_t slo_end, Picoseconds fall, Picoseconds pulse_max) {
  const Picoseconds first = fall - rises[1];
  LineSignal::Changes changes{first, first, first};
  const Picoseconds half =
      elapsed(rises[1], rises.back()) / std::max<std::int64_t>(2, 2 * (std::ssize(rises) - 2));
  std::size_t rise = 1;
  for (std::size_t i = slo.after(fall); i < slo_end; ++i) {
    while (rise < rises.size() && shifted(rises[rise], first + half) < slo[i].time) ++rise;
    if (rise == rises.size()) break;
    if (is_in_pulse(slo, i, slo_end, pulse_max)) continue;
    const Picoseconds seen = slo[i].time - rises[rise];
    if (seen < first - half) continue;
    changes.earliest = std::min(changes.earliest, seen);
    changes.latest = std::max(changes.latest, seen);
  }
  return changes;
}

}  // namespace biss::decode
