#include "decode/clean_cycles.hpp"

#include <algorithm>

#include "decode/cycle_rules.hpp"
#include "decode/times.hpp"

namespace biss::decode {

namespace {

// The next falling edge at or after `from` that comes after an idle time of more than the next two
// periods.
std::size_t next_request(const LineRun& ma, std::size_t from) {
  const auto& times = ma.times;
  // Rising edges have odd indices if the first one falls.
  const std::size_t odd = ma.first_high ? 1 : 0;
  for (std::size_t i = std::max<std::size_t>(from, 1); i + 4 < times.size(); ++i) {
    if (i % 2 != odd) continue;
    const Picoseconds time{times[i]};
    if (elapsed(Picoseconds{times[i - 1]}, time) > elapsed(time, Picoseconds{times[i + 4]})) {
      return i;
    }
  }
  return times.size();
}

std::size_t first_after(const LineRun& slo, std::size_t from, std::int64_t time) {
  const auto& times = slo.times;
  while (from < times.size() && times[from] <= time) ++from;
  return from;
}

}  // namespace

CleanCycleFinder::CleanCycleFinder(const std::optional<FrameFormat>& format,
                                   const DeviceTiming& timing, const MarginSetup& margin)
    : timing_(timing), margin_(margin) {
  if (format) codec_.emplace(format->without_previous());
  needs_next_ = format && format->needs_previous();
  setup_ = {.margin_doubt = margin_doubt(margin).count, .clock_change = timing.clock_constant};
}

void CleanCycleFinder::find(const PairRun& run, std::vector<CleanCycle>& found,
                            std::span<const std::uint8_t> ahead) {
  found.clear();
  if (!may_find()) return;
  // A request has some more edges than this.
  found.reserve(run.ma.times.size() / 64);
  ahead_ = ahead;
  std::size_t slo = 0;
  std::size_t at = next_request(run.ma, 0);
  while (at < run.ma.times.size()) {
    fetch_ahead();
    slo = first_after(run.slo, slo, run.ma.times[at]);
    found.emplace_back();
    CleanCycle& cycle = found.back();
    // Before the first change of this run, SLO is not known.
    const bool high = slo != 0 && run.slo.level(slo - 1) == wire::Level::high;
    const CleanLines lines{run.ma.times.subspan(at), run.slo.times.subspan(slo)};
    // The first change of a run may repeat the level.
    const bool clean =
        high && (slo > 1 || !margin_.signal) && read(cycle, lines) &&
        (!margin_.signal || measure_signal(lines, run.slo.times[slo - 1], cycle.reading.cycle));
    if (clean) {
      cycle.begin = {at, slo};
      at += measured_.next_fall;
      slo += measured_.changes;
      cycle.end = {at, slo};
    } else {
      found.pop_back();
      at = next_request(run.ma, at + 1);
    }
  }
}

// A little at a time: too many loads under way make the processor wait.
void CleanCycleFinder::fetch_ahead() {
  constexpr std::size_t line_bytes = 64;
  constexpr std::size_t lines = 16;
  constexpr int second_level = 2;
  const auto now = ahead_.first(std::min(ahead_.size(), lines * line_bytes));
  for (std::size_t i = 0; i < now.size(); i += line_bytes) {
    __builtin_prefetch(now.data() + i, 0, second_level);
  }
  ahead_ = ahead_.subspan(now.size());
}

bool CleanCycleFinder::read(CleanCycle& cycle, const CleanLines& lines) {
  if (!measure_clean(lines, setup_, scratch_, measured_)) return false;
  CycleReading& reading = cycle.reading;
  reading.cycle.time = Picoseconds{lines.ma[0]};
  measure_times(reading);
  const std::int64_t period = measured_.period;
  if (setup_.clock_change) {
    // A clock that changes more needs a closer look.
    if (measured_.clock_change > period / ClockChange::divisor) return false;
    reading.cycle.clock_change = ClockChange{Picoseconds{measured_.clock_change}, {}};
  }
  const Picoseconds delay{measured_.fall - measured_.second_rise};
  if (!is_response_delay(delay, reading.cycle.uncertainty)) return false;
  reading.cycle.line_delay = std::max(Picoseconds{}, delay);
  return read_frame(reading);
}

// The values measured on MA.
void CleanCycleFinder::measure_times(CycleReading& reading) const {
  Cycle& cycle = reading.cycle;
  cycle.clocked = Picoseconds{measured_.last_edge};
  cycle.rising_edges = measured_.rises;
  cycle.period = Picoseconds{measured_.period};
  reading.jitter = Picoseconds{measured_.jitter};
  cycle.uncertainty = uncertainty_of(margin_, reading.jitter, *cycle.period);
  cycle.duty_per_mille = static_cast<std::uint32_t>(std::int64_t{measured_.high} / measured_.highs *
                                                    1000 / measured_.period);
  // MA rests as its last edge left it.
  cycle.cdm = measured_.edges % 2 != 0;
}

// The values measured on SLO. With a format, only good frames are clean.
bool CleanCycleFinder::read_frame(CycleReading& reading) {
  Cycle& cycle = reading.cycle;
  const std::size_t start_bit = measured_.bits().find(true, 2);
  if (start_bit == measured_.rises) return false;
  if (!read_payload(start_bit, cycle)) return false;
  if (!ack_within_bounds(timing_, *cycle.period, static_cast<std::uint16_t>(start_bit - 1))) {
    cycle.status = CycleStatus::ack_range;
    cycle.frame.reset();
  }
  // The last change that the sample of START sees: nearly always the second one.
  std::size_t rise = 1;
  while (rise + 1 < measured_.changes &&
         static_cast<std::size_t>(scratch_.samples[rise + 1]) <= start_bit) {
    ++rise;
  }
  cycle.ack = Picoseconds{scratch_.changes[rise] - measured_.fall};
  // Without a format, the last clock is taken as STOP.
  const std::size_t stop =
      codec_ ? start_bit + 2 + codec_->payload_bits() : std::size_t{measured_.rises} - 1;
  cycle.release = release(stop);
  if (*cycle.period / margin_share >= margin_doubt(margin_)) {
    cycle.marginal = static_cast<std::uint32_t>(measured_.first_marginal) <= stop;
  }
  reading.complete = true;
  return true;
}

bool CleanCycleFinder::read_payload(std::size_t start_bit, Cycle& cycle) const {
  const BitView bits = measured_.bits();
  if (!codec_) {
    cycle.raw.append(bits.from(start_bit).first(RawBits::capacity_bits));
    cycle.status = CycleStatus::unchecked;
    return true;
  }
  // The bits begin with LAT and ACK.
  const FrameStart start{start_bit, 1, static_cast<std::uint16_t>(start_bit - 1)};
  const auto frame = decode_payload(bits, start, *codec_);
  if (!frame.ok()) return false;
  cycle.frame = *frame;
  if (needs_next_) cycle.status = CycleStatus::unchecked;
  cycle.raw.append(bits.from(start_bit).first(codec_->payload_bits() + 3U));
  const auto channels = codec_->format().channels();
  for (std::size_t k = 0; k < channels.size(); ++k) {
    if (channels[k].crc.present()) cycle.crc_ok[k] = true;
  }
  return true;
}

// False if a level is as short as a pulse.
bool CleanCycleFinder::measure_signal(const CleanLines& lines, std::int64_t high_since,
                                      Cycle& cycle) const {
  LineSignal signal;
  const std::uint32_t high = std::min(*cycle.duty_per_mille, 1000U);
  signal.pulse_max = *cycle.period * std::int64_t{std::min(high, 1000U - high)} / 2000;
  const auto shortest = [](std::span<const std::int64_t> times) {
    Picoseconds least{INT64_MAX};
    for (std::size_t i = 1; i < times.size(); ++i) {
      least = std::min(least, elapsed(Picoseconds{times[i - 1]}, Picoseconds{times[i]}));
    }
    return least;
  };
  signal.ma_shortest = shortest(lines.ma.first(measured_.edges));
  if (*signal.ma_shortest < signal.pulse_max) return false;
  if (shortest(lines.slo.first(measured_.changes)) < signal.pulse_max) return false;
  signal.ready = elapsed(Picoseconds{high_since}, cycle.time);
  if (codec_) {
    if (!cycle.frame) return false;
    const std::size_t stop = cycle.frame->ack_clocks + std::size_t{3} + codec_->payload_bits();
    signal.frame_clocks = static_cast<std::uint32_t>(stop + 1);
    signal.changes = measure_changes(lines, std::min<std::size_t>(stop + 1, measured_.rises));
  }
  cycle.signal = signal;
  return true;
}

// The same as decode::measure_changes(), but without pulses.
LineSignal::Changes CleanCycleFinder::measure_changes(const CleanLines& lines,
                                                      std::size_t rises) const {
  const auto rise_at = [&](std::size_t rise) { return lines.ma[2 * rise + 1] - lines.ma[0]; };
  const std::int64_t first = measured_.fall - measured_.second_rise;
  const std::int64_t half = (rise_at(rises - 1) - rise_at(1)) /
                            std::max<std::int64_t>(2, 2 * static_cast<std::int64_t>(rises) - 4);
  LineSignal::Changes changes{Picoseconds{first}, Picoseconds{first}, Picoseconds{measured_.delay}};
  std::size_t rise = 1;
  for (std::size_t i = 1; i < measured_.changes; ++i) {
    const std::int64_t change = elapsed(Picoseconds{lines.ma[0]}, Picoseconds{lines.slo[i]}).count;
    while (rise < rises && rise_at(rise) + first + half < change) ++rise;
    if (rise == rises) break;
    const Picoseconds seen{change - rise_at(rise)};
    if (seen.count < first - half) continue;
    changes.earliest = std::min(changes.earliest, seen);
    changes.latest = std::max(changes.latest, seen);
  }
  return changes;
}

// The one rise of SLO after the last bit.
std::optional<Picoseconds> CleanCycleFinder::release(std::size_t last_bit) const {
  const std::size_t stop = std::min<std::size_t>(last_bit, measured_.rises - 1);
  std::size_t next = measured_.changes;
  while (next > 0 && static_cast<std::size_t>(scratch_.samples[next - 1]) > stop) --next;
  const bool low = next % 2 != 0;
  if (!low || next == measured_.changes) return std::nullopt;
  const std::int32_t rise = scratch_.changes[next];
  if (rise >= measured_.limit) return std::nullopt;
  if (next + 1 < measured_.changes && scratch_.changes[next + 1] < measured_.limit) {
    return std::nullopt;
  }
  return Picoseconds{rise - measured_.last_edge};
}

}  // namespace biss::decode
