#include "decode/cycle_reader.hpp"

#include <algorithm>

namespace biss::decode {

namespace {

// A distance of rising edges outside these shares of the usual one means that an edge is missing or
// too many: a lost edge doubles it, an extra one leaves at most half. Between lies the jitter of a
// capture with only two samples a period.
constexpr std::int64_t irregular_above_percent = 160;
constexpr std::int64_t irregular_below_percent = 55;

bool irregular(Picoseconds interval, Picoseconds usual) {
  return interval.count * 100 > usual.count * irregular_above_percent ||
         interval.count * 100 < usual.count * irregular_below_percent;
}

Picoseconds median_interval(const std::vector<Picoseconds>& rises) {
  std::vector<Picoseconds> intervals;
  intervals.reserve(rises.size());
  for (std::size_t i = 1; i < rises.size(); ++i) intervals.push_back(rises[i] - rises[i - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

bool has_unknown(std::span<const LevelChange> ma) {
  return std::any_of(ma.begin(), ma.end(), [](const LevelChange& change) {
    return change.level == wire::Level::unknown;
  });
}

// The period is measured, so a bound that falls just beside a clock edge is given 2 % of grace.
bool ack_within_bounds(const DeviceTiming& timing, Picoseconds period, std::uint16_t ack_clocks) {
  const Picoseconds grace = period / 50;
  return ack_clocks >= ack_bounds(timing, period + grace).min_clocks &&
         ack_clocks <= ack_bounds(timing, std::max(period - grace, picoseconds(1))).max_clocks;
}

// A request that has no second rising edge yet, and the capture is over before one was due.
bool ends_with_capture(const CycleSpan& span) {
  if (!span.last_of_capture) return false;
  if (span.ma.size() < 2) return true;
  return span.limit - span.ma.back().time <= 4 * (span.ma[1].time - span.ma[0].time);
}

// The rising edge that made the level at `time` high.
std::optional<Picoseconds> rise_before(const LineHistory& slo, Picoseconds time) {
  const std::size_t next = slo.after(time);
  if (next == 0 || slo[next - 1].level != wire::Level::high) return std::nullopt;
  return slo[next - 1].time;
}

}  // namespace

CycleReader::CycleReader(std::optional<FrameFormat> format, const DeviceTiming& timing)
    : timing_(timing) {
  if (format) codec_.emplace(*format);
}

CycleReading CycleReader::read(const CycleSpan& span, const LineHistory& slo) const {
  CycleReading reading;
  Cycle& cycle = reading.cycle;
  const auto fall = std::find_if(span.ma.begin(), span.ma.end(), [](const LevelChange& change) {
    return change.level == wire::Level::low;
  });
  cycle.time = fall == span.ma.end() ? span.ma.front().time : fall->time;
  const auto ends_as = [&](CycleStatus status) {
    cycle.status = status;
    return reading;
  };
  const Clock clock = measure_clock(span.ma, cycle);
  if (has_unknown(span.ma)) return ends_as(CycleStatus::unknown_level);
  if (!span.begins_idle) return ends_as(CycleStatus::cut_start);
  if (clock.rises.size() < 2) {
    return ends_as(ends_with_capture(span) ? CycleStatus::cut_end : CycleStatus::ma_glitch);
  }
  if (const auto cause = find_response(span, slo, clock, cycle)) return ends_as(*cause);
  const Sampled sampled = sample(span, slo, clock, *cycle.line_delay);
  if (sampled.bits.size_bits() > 0) {
    const std::size_t start = sampled.bits.view().find(true, 1);
    if (start < sampled.bits.size_bits()) {
      const Picoseconds seen = clock.rises[start] + *cycle.line_delay + clock.period / 2;
      if (const auto rise = rise_before(slo, seen)) {
        cycle.ack = *rise - (clock.rises[1] + *cycle.line_delay);
      }
    }
  }
  return judge(span, sampled, clock, std::move(reading));
}

CycleReader::Clock CycleReader::measure_clock(std::span<const LevelChange> ma, Cycle& cycle) {
  Clock clock;
  for (const LevelChange& change : ma) {
    if (change.level == wire::Level::high) clock.rises.push_back(change.time);
  }
  cycle.rising_edges = static_cast<std::uint32_t>(clock.rises.size());
  if (clock.rises.size() < 2) return clock;
  const Picoseconds usual = median_interval(clock.rises);
  Picoseconds sum{};
  std::int64_t count = 0;
  for (std::size_t i = 1; i < clock.rises.size(); ++i) {
    const Picoseconds interval = clock.rises[i] - clock.rises[i - 1];
    if (irregular(interval, usual)) {
      clock.first_irregular = std::min(clock.first_irregular, i);
      continue;
    }
    sum += interval;
    ++count;
  }
  clock.period = Picoseconds{(sum.count + count / 2) / count};
  Picoseconds high{};
  std::int64_t highs = 0;
  for (std::size_t i = 1; i + 1 < ma.size(); ++i) {
    const bool pulse = ma[i].level == wire::Level::high && ma[i + 1].level == wire::Level::low;
    if (!pulse || irregular(ma[i + 1].time - ma[i - 1].time, usual)) continue;
    high += ma[i + 1].time - ma[i].time;
    ++highs;
  }
  cycle.period = clock.period;
  if (highs != 0 && clock.period.count > 0) {
    cycle.duty_per_mille =
        static_cast<std::uint32_t>(high.count * 1000 / highs / clock.period.count);
  }
  return clock;
}

// Sets the line delay, or tells why there is none.
std::optional<CycleStatus> CycleReader::find_response(const CycleSpan& span, const LineHistory& slo,
                                                      const Clock& clock, Cycle& cycle) {
  const wire::Level at_begin = slo.level_at(span.ma.front().time);
  if (at_begin == wire::Level::unknown) return CycleStatus::unknown_level;
  if (at_begin == wire::Level::low) return CycleStatus::not_ready;
  // A capture may show SLO a sample before the edge of MA that moved it.
  const Picoseconds second_rise = clock.rises[1];
  const Picoseconds earliest = second_rise - clock.period / 4;
  if (slo.level_at(earliest) == wire::Level::low) return CycleStatus::response_range;
  bool late = false;
  for (std::size_t i = slo.after(earliest); i < slo.size(); ++i) {
    const LevelChange& change = slo[i];
    if (change.time > span.limit) break;
    if (change.level == wire::Level::unknown) return CycleStatus::unknown_level;
    if (change.level != wire::Level::low) continue;
    const Picoseconds delay = std::max(Picoseconds{}, change.time - second_rise);
    if (delay > biss_line_delay_max) {
      late = true;
      break;
    }
    // ACK is low for a clock at least; anything shorter is a glitch on SLO.
    if (slo.level_at(second_rise + delay + clock.period / 2) != wire::Level::low) continue;
    cycle.line_delay = delay;
    return std::nullopt;
  }
  if (late) return CycleStatus::response_range;
  const bool waited = span.limit - second_rise >= std::max(clock.period, biss_line_delay_max);
  const bool clock_goes_on = span.limit - clock.rises.back() < clock.period;
  return span.last_of_capture && !waited && clock_goes_on ? CycleStatus::cut_end
                                                          : CycleStatus::no_response;
}

CycleReader::Sampled CycleReader::sample(const CycleSpan& span, const LineHistory& slo,
                                         const Clock& clock, Picoseconds line_delay) {
  Sampled sampled;
  sampled.bits.append(true);  // LAT: SLO was high when ACK fell
  for (std::size_t i = 1; i < clock.rises.size() && !sampled.bits.overflowed(); ++i) {
    const Picoseconds at = clock.rises[i] + line_delay + clock.period / 2;
    if (at > span.limit) {
      sampled.reached_limit = true;
      break;
    }
    const wire::Level level = slo.level_at(at);
    if (level == wire::Level::unknown) {
      sampled.reached_unknown = true;
      break;
    }
    sampled.bits.append(level == wire::Level::high);
  }
  return sampled;
}

CycleReading CycleReader::judge(const CycleSpan& span, const Sampled& sampled, const Clock& clock,
                                CycleReading reading) const {
  Cycle& cycle = reading.cycle;
  constexpr FrameBounds anywhere{.lead_max_clocks = 1, .ack_max_clocks = UINT16_MAX};
  const auto start = find_start(sampled.bits.view(), anywhere);
  std::size_t last_bit = clock.rises.size() - 1;
  if (start.ok()) {
    reading.complete = !codec_ && !sampled.reached_limit;
    read_payload(sampled, *start, reading);
    if (!ack_within_bounds(timing_, clock.period, start->ack_clocks)) {
      cycle.status = CycleStatus::ack_range;
    }
    if (codec_) last_bit = std::min(last_bit, start->start_bit + 1 + codec_->payload_bits());
  } else {
    cycle.status = status_of(start.error().cause);
  }
  const bool bits_missing =
      cycle.status == CycleStatus::no_start || cycle.status == CycleStatus::truncated;
  if (clock.first_irregular <= last_bit) {
    cycle.status = CycleStatus::ma_clock;
  } else if (bits_missing && sampled.reached_unknown) {
    cycle.status = CycleStatus::unknown_level;
  } else if (bits_missing && span.last_of_capture &&
             (sampled.reached_limit ||
              span.limit - clock.rises.back() < clock.period + clock.period / 2)) {
    cycle.status = CycleStatus::cut_end;
  }
  if (cycle.status != CycleStatus::ok) cycle.frame.reset();
  return reading;
}

void CycleReader::read_payload(const Sampled& sampled, const FrameStart& start,
                               CycleReading& reading) const {
  Cycle& cycle = reading.cycle;
  const BitView bits = sampled.bits.view();
  const std::size_t wanted = codec_ ? codec_->payload_bits() + 3U : RawBits::capacity_bits;
  const BitView raw = bits.from(start.start_bit).first(std::min(wanted, RawBits::capacity_bits));
  for (std::size_t i = 0; i < raw.size_bits(); ++i) cycle.raw.append(raw.bit(i));
  if (!codec_) return;
  std::size_t at = 2;
  const auto channels = codec_->format().channels();
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const ChannelFormat& channel = channels[k];
    const std::size_t end = at + channel.total_bits();
    if (end > raw.size_bits()) break;
    if (channel.crc.present()) {
      const std::uint64_t data = raw.word(at, channel.data_bits);
      cycle.crc_ok[k] =
          raw.word(at + channel.data_bits, channel.crc.width_bits) == codec_->crc(k, data);
    }
    at = end;
  }
  const auto frame = decode_payload(bits, start, *codec_);
  if (frame.ok()) {
    cycle.frame = *frame;
  } else {
    cycle.status = status_of(frame.error().cause);
  }
  reading.complete = frame.ok() || frame.error().cause != FrameError::truncated;
}

}  // namespace biss::decode
