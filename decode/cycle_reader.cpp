#include "decode/cycle_reader.hpp"

#include <algorithm>

#include "biss/timing/cable.hpp"
#include "decode/cycle_rules.hpp"
#include "decode/times.hpp"

namespace biss::decode {

namespace {

using wire::Level;

// Peak-to-peak jitter of a period over the usual difference of two neighbours: 4 for jitter that is
// evenly spread, and a reserve.
constexpr std::int64_t jitter_factor = 5;

// The ACK of this device is judged separately.
constexpr FrameBounds anywhere{.lead_max_clocks = 1, .ack_max_clocks = UINT16_MAX};

bool has_unknown(std::span<const LevelChange> ma) {
  return std::any_of(ma.begin(), ma.end(),
                     [](const LevelChange& change) { return change.level == Level::unknown; });
}

// A request that has no second rising edge yet, and the capture is over before one was due.
bool ends_with_capture(const CycleSpan& span) {
  if (!span.last_of_capture) return false;
  if (span.ma.size() < 2) return true;
  return elapsed(span.ma.back().time, span.limit) <= 4 * elapsed(span.ma[0].time, span.ma[1].time);
}

// The rising edge that made the level before change `next` high.
std::optional<Picoseconds> rise_before(const LineHistory& slo, std::size_t next) {
  if (next == 0 || slo[next - 1].level != Level::high) return std::nullopt;
  return slo[next - 1].time;
}

}  // namespace

CycleReader::CycleReader(std::optional<FrameFormat> format, const DeviceTiming& timing,
                         const MarginSetup& margin)
    : timing_(timing), margin_(margin) {
  if (format) codec_.emplace(format->without_previous());
  if (format && format->needs_previous()) checked_by_next_ = format;
}

CycleReading CycleReader::read(const CycleSpan& span, const LineHistory& slo) {
  answer_.reset();
  // Changes from the next request on do not belong to this request, even if they are already known.
  slo_end_ = span.last_of_capture ? slo.size() : slo.from(span.limit);
  CycleReading reading = read_answer(span, slo);
  Cycle& cycle = reading.cycle;
  if (margin_.signal && cycle.period && span.begins_idle &&
      cycle.status != CycleStatus::unknown_level) {
    cycle.signal = signal(span, slo, cycle);
  }
  return reading;
}

LineSignal CycleReader::signal(const CycleSpan& span, const LineHistory& slo,
                               const Cycle& cycle) const {
  LineSignal signal = measure_signal({.ma = span.ma,
                                      .limit = span.limit,
                                      .slo_end = slo_end_,
                                      .period = clock_.period,
                                      .duty_per_mille = cycle.duty_per_mille.value_or(500),
                                      .resolution = margin_.resolution},
                                     slo);
  if (!answer_) return signal;
  const std::size_t rises = clock_.rises.size();
  const std::size_t stop = answer_->stop.value_or(rises - 1);
  if (answer_->stop) signal.frame_clocks = static_cast<std::uint32_t>(stop + 1);
  // Without a format, the last change may be the end of the timeout.
  if (!answer_->stop || clock_.first_irregular <= stop) return signal;
  const auto seen = std::span<const Picoseconds>(clock_.rises).first(std::min(stop + 1, rises));
  signal.changes = measure_changes(seen, slo, slo_end_, answer_->fall, signal.pulse_max);
  signal.changes->sampled = answer_->delay;
  return signal;
}

CycleReading CycleReader::read_answer(const CycleSpan& span, const LineHistory& slo) {
  CycleReading reading;
  Cycle& cycle = reading.cycle;
  sampled_after_.reset();
  const auto fall = std::find_if(span.ma.begin(), span.ma.end(), [](const LevelChange& change) {
    return change.level == Level::low;
  });
  cycle.time = fall == span.ma.end() ? span.ma.front().time : fall->time;
  cycle.clocked = elapsed(cycle.time, std::max(cycle.time, span.ma.back().time));
  measure_clock(span.ma, cycle);
  if (has_unknown(span.ma)) {
    cycle.status = CycleStatus::unknown_level;
  } else if (!span.begins_idle) {
    cycle.status = CycleStatus::cut_start;
    reading.complete = true;
  } else if (clock_.rises.size() < 2) {
    cycle.status = ends_with_capture(span) ? CycleStatus::cut_end : CycleStatus::ma_glitch;
  } else {
    cycle.cdm = resting_level(span);
    reading.jitter = clock_.jitter;
    const Response response = find_response(span, slo);
    cycle.status = response.status;
    if (response.status == CycleStatus::response_range && response.fall < clock_.rises[1]) {
      cycle.early = elapsed(response.fall, clock_.rises[1]);
    }
    if (response.status != CycleStatus::ok) return reading;
    cycle.line_delay = std::max(Picoseconds{}, response.fall - clock_.rises[1]);
    const Picoseconds delay = sampling_delay(slo, response.fall);
    sampled_after_ = delay + clock_.period / 2;
    const Sampled sampled = sample(span, slo, delay);
    const auto start = find_start(sampled.bits.view(), anywhere);
    if (start.ok()) {
      const Picoseconds sampled_at = shifted(clock_.rises[start->start_bit], *sampled_after_);
      const auto rise = rise_before(slo, std::min(slo.after(sampled_at), slo_end_));
      if (rise && *rise > response.fall) cycle.ack = *rise - response.fall;
      answer_ = {response.fall, delay, std::nullopt};
      if (codec_) answer_->stop = start->start_bit + 2 + codec_->payload_bits();
    }
    judge(span, slo, delay, sampled, start, reading);
    const std::size_t stop = answer_ && answer_->stop ? *answer_->stop : clock_.rises.size();
    cycle.release = release(span, slo, delay, stop - 1);
    cycle.marginal = judge_margin(span, slo, response.fall, sampled,
                                  start.ok() ? start->start_bit : sampled.bits.size_bits());
  }
  return reading;
}

std::vector<Picoseconds> CycleReader::sample_times() const {
  std::vector<Picoseconds> times;
  if (!sampled_after_) return times;
  for (const Picoseconds rise : clock_.rises) times.push_back(shifted(rise, *sampled_after_));
  return times;
}

void CycleReader::measure_clock(std::span<const LevelChange> ma, Cycle& cycle) {
  clock_.rises.clear();
  clock_.intervals.clear();
  clock_.first_irregular = SIZE_MAX;
  clock_.first_early = SIZE_MAX;
  for (const LevelChange& change : ma) {
    if (change.level != Level::high) continue;
    if (!clock_.rises.empty()) {
      clock_.intervals.push_back(elapsed(clock_.rises.back(), change.time));
    }
    clock_.rises.push_back(change.time);
  }
  cycle.rising_edges = static_cast<std::uint32_t>(clock_.rises.size());
  if (clock_.rises.size() < 2) return;
  clock_.period = usual_period();
  // Edges at one and the same time have no period.
  clock_.period = std::max(clock_.period, picoseconds(1));
  cycle.period = clock_.period;
  cycle.uncertainty = uncertainty();
  if (timing_.clock_constant) cycle.clock_change = measure_change();
  measure_duty(ma, cycle);
}

Picoseconds CycleReader::uncertainty() const {
  return uncertainty_of(margin_, clock_.jitter, clock_.period);
}

// Jitter moves each edge about its place, so that it changes the time of 8 periods no more than the
// time of one. A different clock rate changes it eight times as much.
ClockChange CycleReader::measure_change() const {
  const std::vector<Picoseconds>& rises = clock_.rises;
  Picoseconds most{};
  for (std::size_t periods = 1; periods <= 8 && periods < rises.size(); periods *= 2) {
    Picoseconds shortest = elapsed(rises[0], rises[periods]);
    Picoseconds longest = shortest;
    for (std::size_t i = periods + 1; i < rises.size(); ++i) {
      const Picoseconds time = elapsed(rises[i - periods], rises[i]);
      shortest = std::min(shortest, time);
      longest = std::max(longest, time);
    }
    most = std::max(most, longest - shortest);
  }
  if (most <= clock_.period / ClockChange::divisor) return {most, {}};
  return {most, 2 * margin_.resolution + jitter_in_doubt()};
}

// The jitter that neighbouring periods show: a step of the clock is not part of it.
Picoseconds CycleReader::jitter_in_doubt() const {
  std::vector<Picoseconds> steps;
  for (std::size_t i = 1; i < clock_.intervals.size(); ++i) {
    const Picoseconds step = clock_.intervals[i] - clock_.intervals[i - 1];
    steps.push_back(std::max(step, -step));
  }
  if (steps.empty()) return {};
  return std::min(jitter_factor * median(steps), clock_.period / uncertain_share);
}

// The mean of the intervals that are a period; notes the first interval that is not.
Picoseconds CycleReader::usual_period() {
  const auto [least, most] = std::minmax_element(clock_.intervals.begin(), clock_.intervals.end());
  // The median is computed only if it can change the verdict on an interval.
  const bool even = !irregular(*most, *least);
  Picoseconds usual = *least;
  if (!even) {
    std::vector<Picoseconds> values = clock_.intervals;
    usual = median(values);
  }
  Picoseconds sum{};
  Picoseconds shortest = usual;
  Picoseconds longest = usual;
  std::int64_t count = 0;
  for (std::size_t i = 0; i < clock_.intervals.size(); ++i) {
    const Picoseconds interval = clock_.intervals[i];
    if (!even && irregular(interval, usual)) {
      clock_.first_irregular = std::min(clock_.first_irregular, i + 1);
      if (interval < usual) clock_.first_early = std::min(clock_.first_early, i + 1);
      continue;
    }
    sum += interval;
    shortest = std::min(shortest, interval);
    longest = std::max(longest, interval);
    ++count;
  }
  clock_.jitter = longest - shortest;
  return (sum + picoseconds(count / 2)) / count;
}

void CycleReader::measure_duty(std::span<const LevelChange> ma, Cycle& cycle) const {
  Picoseconds high{};
  std::int64_t highs = 0;
  for (std::size_t i = 1; i + 1 < ma.size(); ++i) {
    if (ma[i].level != Level::high) continue;
    if (irregular(elapsed(ma[i - 1].time, ma[i + 1].time), clock_.period)) continue;
    high += elapsed(ma[i].time, ma[i + 1].time);
    ++highs;
  }
  if (highs == 0) return;
  cycle.duty_per_mille =
      static_cast<std::uint32_t>(high.count / highs * 1000 / clock_.period.count);
}

// ACK is the first low of SLO that lasts half a period; anything shorter is a glitch.
CycleReader::Response CycleReader::find_response(const CycleSpan& span,
                                                 const LineHistory& slo) const {
  const std::size_t begin = slo.after(span.ma.front().time);
  if (slo.level_before(begin) == Level::unknown) return {{}, CycleStatus::unknown_level};
  const bool ready = slo.level_before(begin) == Level::high;
  const Picoseconds second_rise = clock_.rises[1];
  // The capture and the jitter of MA may show SLO before the edge of MA that moved it.
  const Picoseconds earliest = shifted(second_rise, -uncertainty());
  for (std::size_t i = begin; i < slo_end_ && slo[i].time < span.limit; ++i) {
    if (slo[i].level == Level::unknown) return {{}, CycleStatus::unknown_level};
    if (slo[i].level != Level::low) continue;
    Picoseconds settled = shifted(slo[i].time, clock_.period / 2);
    if (slo[i].time < earliest) settled = std::max(settled, second_rise);
    if (i + 1 < slo_end_ && slo[i + 1].time <= settled) continue;
    if (!ready && !ready_in_time(slo, i)) return {{}, CycleStatus::not_ready};
    const Picoseconds delay = slo[i].time < second_rise ? -elapsed(slo[i].time, second_rise)
                                                        : elapsed(second_rise, slo[i].time);
    const bool in_range = is_response_delay(delay, uncertainty());
    return {slo[i].time, in_range ? CycleStatus::ok : CycleStatus::response_range};
  }
  return {{}, ready ? silence(span) : CycleStatus::not_ready};
}

// An encoder with a fixed cycle time may get a request that arrives just when it is ready. The
// master sees SLO rise a line delay later, a clock and a half before ACK. This is accepted only
// within the delay of the longest cable, because an inverted SLO looks much the same.
bool CycleReader::ready_in_time(const LineHistory& slo, std::size_t ack) const {
  if (timing_.timeout.rule != TimeoutRule::cycle || ack == 0) return false;
  const Picoseconds longest =
      line_delay(metres(100), timing_.internal_delay_max) + clock_.period / 2;
  return slo[ack - 1].level == Level::high &&
         slo[ack].time >= shifted(slo[ack - 1].time, clock_.period * 5 / 4) &&
         slo[ack].time <= shifted(clock_.rises[1], longest);
}

// CDM is the inverse of the level at which MA rests until the encoder is ready.
std::optional<bool> CycleReader::resting_level(const CycleSpan& span) const {
  const LevelChange& last = span.ma.back();
  const bool seen = !span.last_of_capture || elapsed(last.time, span.limit) > clock_.period;
  return seen ? std::optional(last.level == Level::low) : std::nullopt;
}

// SLO rises once after STOP, or after the last clock if that one comes earlier.
std::optional<Picoseconds> CycleReader::release(const CycleSpan& span, const LineHistory& slo,
                                                Picoseconds delay, std::size_t last_bit) const {
  const std::size_t stop = std::min(last_bit + 1, clock_.rises.size() - 1);
  const std::size_t next = slo.after(shifted(clock_.rises[stop], delay + clock_.period / 2));
  if (slo.level_before(next) != Level::low || next >= slo.size()) return std::nullopt;
  const Picoseconds rise = slo[next].time;
  if (slo[next].level != Level::high || rise >= span.limit) return std::nullopt;
  if (next + 1 < slo.size() && slo[next + 1].time < span.limit) return std::nullopt;
  const Picoseconds last = span.ma.back().time;
  return rise < last ? -elapsed(rise, last) : elapsed(last, rise);
}

// SLO never fell: the capture ended before an answer was due, or there was no answer.
CycleStatus CycleReader::silence(const CycleSpan& span) const {
  const Picoseconds asked = elapsed(clock_.rises[1], std::max(span.limit, clock_.rises[1]));
  const Picoseconds idle = elapsed(clock_.rises.back(), std::max(span.limit, clock_.rises.back()));
  const bool waited = asked >= std::max(clock_.period, biss_line_delay_max);
  const bool may_clock_on = 2 * idle < 3 * clock_.period;
  return span.last_of_capture && !waited && may_clock_on ? CycleStatus::cut_end
                                                         : CycleStatus::no_response;
}

// From a rising edge of MA to SLO's change, averaged over the cycle: in a capture with few samples
// per period, one edge alone may be off by nearly half a period. The edges of MA are then off as
// well, and an even clock fitted to them shows better to which edge a change belongs.
Picoseconds CycleReader::sampling_delay(const LineHistory& slo, Picoseconds fall) {
  const Delay seen = delay_from(clock_.rises, slo, fall);
  if (8 * seen.spread <= clock_.period || !lay_even_clock()) return seen.mean;
  const Delay even = delay_from(clock_.even_rises, slo, fall);
  return even.spread < seen.spread ? even.mean : seen.mean;
}

CycleReader::Delay CycleReader::delay_from(const std::vector<Picoseconds>& rises,
                                           const LineHistory& slo, Picoseconds fall) const {
  const Picoseconds first = fall - rises[1];
  const Picoseconds half = clock_.period / 2;
  Picoseconds sum{};
  Picoseconds least{};
  Picoseconds most{};
  std::int64_t count = 1;  // ACK's own edge has the offset 0
  std::size_t rise = 1;
  for (std::size_t i = slo.after(fall); i < slo_end_; ++i) {
    while (rise < rises.size() && shifted(rises[rise], first + half) < slo[i].time) ++rise;
    if (rise == rises.size()) break;
    const Picoseconds off = slo[i].time - shifted(rises[rise], first);
    if (off < -half) continue;
    sum += off;
    least = std::min(least, off);
    most = std::max(most, off);
    ++count;
  }
  return {first + sum / count, most - least};
}

// False if the clock is not even.
bool CycleReader::lay_even_clock() {
  if (clock_.first_irregular != SIZE_MAX) return false;
  const auto size = static_cast<std::int64_t>(clock_.rises.size());
  Picoseconds sum{};
  for (std::int64_t i = 0; i < size; ++i) {
    const auto index = static_cast<std::size_t>(i);
    const Picoseconds off = clock_.rises[index] - clock_.rises[0] - i * clock_.period;
    if (2 * off > clock_.period || -2 * off > clock_.period) return false;
    sum += off;
  }
  const Picoseconds begin = shifted(clock_.rises[0], sum / size);
  clock_.even_rises.clear();
  for (std::int64_t i = 0; i < size; ++i) {
    clock_.even_rises.push_back(shifted(begin, i * clock_.period));
  }
  return true;
}

CycleReader::Sampled CycleReader::sample(const CycleSpan& span, const LineHistory& slo,
                                         Picoseconds delay) const {
  Sampled sampled;
  sampled.bits.append(true);   // LAT: SLO was high when ACK fell
  sampled.bits.append(false);  // ACK
  const Picoseconds middle = delay + clock_.period / 2;
  const Picoseconds margin = certain_margin();
  Picoseconds before = shifted(clock_.rises[1], middle);
  std::size_t next = std::min(slo.after(before), slo_end_);
  if (next != 0 && elapsed(slo[next - 1].time, before) <= margin) sampled.first_marginal = 1;
  std::size_t i = 2;
  for (; i < clock_.rises.size() && !sampled.bits.overflowed(); ++i) {
    const Picoseconds at = shifted(clock_.rises[i], middle);
    if (at > span.limit) {
      sampled.reached_limit = true;
      break;
    }
    for (; next < slo_end_ && slo[next].time <= at; ++next) {
      if (sampled.first_marginal != SIZE_MAX) continue;
      if (elapsed(before, slo[next].time) <= margin)
        sampled.first_marginal = i - 1;
      else if (elapsed(slo[next].time, at) <= margin)
        sampled.first_marginal = i;
    }
    before = at;
    const Level level = slo.level_before(next);
    if (level == Level::unknown) {
      sampled.reached_unknown = true;
      break;
    }
    sampled.bits.append(level == Level::high);
  }
  const bool changes = next < slo_end_ && elapsed(before, slo[next].time) <= margin;
  if (changes) sampled.first_marginal = std::min(sampled.first_marginal, i - 1);
  return sampled;
}

// How close a change of SLO must be to be certainly within the margin; negative if no change is
// certain.
Picoseconds CycleReader::certain_margin() const {
  return clock_.period / margin_share - margin_doubt(margin_);
}

std::optional<bool> CycleReader::judge_margin(const CycleSpan& span, const LineHistory& slo,
                                              Picoseconds fall, const Sampled& sampled,
                                              std::size_t start) const {
  if (certain_margin().count < 0) return std::nullopt;
  // After STOP nothing is sampled.
  const std::size_t last = codec_ ? start + 2 + codec_->payload_bits() : clock_.rises.size() - 1;
  if (margin_.compensated) return sampled.first_marginal <= last;
  const Picoseconds half = clock_.period / 2;
  std::size_t lead = 1;
  while (lead < clock_.rises.size() && shifted(clock_.rises[lead], half) < fall) ++lead;
  return sample(span, slo, {}).first_marginal <= last + lead - 1;
}

void CycleReader::judge(const CycleSpan& span, const LineHistory& slo, Picoseconds delay,
                        const Sampled& sampled, const FoundStart& start,
                        CycleReading& reading) const {
  Cycle& cycle = reading.cycle;
  std::size_t last_bit = clock_.rises.size() - 1;
  if (start.ok()) {
    read_payload(sampled, *start, reading);
    if (!ack_within_bounds(timing_, clock_.period, start->ack_clocks)) {
      cycle.status = CycleStatus::ack_range;
    }
    if (codec_) last_bit = std::min(last_bit, start->start_bit + 1 + codec_->payload_bits());
  } else {
    cycle.status = status_of(start.error().cause);
  }
  if (clock_.first_irregular <= last_bit &&
      !pauses_are_certain(span, slo, delay, last_bit, cycle)) {
    cycle.status = CycleStatus::ma_clock;
    cycle.pauses = 0;
    cycle.longest_pause = {};
  } else if (const auto fault = fault_of_capture(span, sampled, cycle.status)) {
    cycle.status = *fault;
  }
  if (cycle.status != CycleStatus::ok) cycle.frame.reset();
  if (cycle.status == CycleStatus::ok && (!codec_ || needs_next())) {
    cycle.status = CycleStatus::unchecked;
  }
}

void CycleReader::judge_by_next(Cycle& cycle, const Cycle* next) const {
  if (!cycle.frame) return;
  const BitView raw = cycle.raw.view();
  const BitView later = next != nullptr ? next->raw.view() : BitView();
  cycle.status = CycleStatus::ok;
  std::size_t at = 2;
  for (std::size_t k = 0; k < checked_by_next_->channel_count; ++k) {
    const ChannelFormat& channel = checked_by_next_->channel_list[k];
    const std::size_t crc_at = at + channel.data_bits;
    at += channel.total_bits();
    if (!channel.crc.of_previous) continue;
    if (at > later.size_bits()) {
      cycle.status = CycleStatus::unchecked;
      break;
    }
    const std::uint16_t crc = frame_detail::deviating_crc(
        channel, raw.word(crc_at - channel.data_bits, channel.data_bits), raw[1]);
    cycle.crc_ok[k] = later.word(crc_at, channel.crc.width_bits) == crc;
    if (!*cycle.crc_ok[k]) cycle.status = CycleStatus::crc;
  }
  if (cycle.status != CycleStatus::ok) cycle.frame.reset();
}

Cycle CycleReader::read_bits(const BitView& bits) const {
  Sampled sampled;
  sampled.bits.append(bits.first(FrameBits::capacity_bits));
  CycleReading reading;
  Cycle& cycle = reading.cycle;
  const auto start = find_start(sampled.bits.view(), FrameBounds{});
  if (start.ok()) {
    read_payload(sampled, *start, reading);
    if (cycle.status == CycleStatus::ok && !codec_) cycle.status = CycleStatus::unchecked;
  } else {
    cycle.status = status_of(start.error().cause);
  }
  return cycle;
}

void CycleReader::read_payload(const Sampled& sampled, const FrameStart& start,
                               CycleReading& reading) const {
  Cycle& cycle = reading.cycle;
  const BitView bits = sampled.bits.view();
  const std::size_t wanted = codec_ ? codec_->payload_bits() + 3U : RawBits::capacity_bits;
  cycle.raw.append(bits.from(start.start_bit).first(std::min(wanted, RawBits::capacity_bits)));
  if (!codec_) {
    reading.complete = !sampled.reached_limit;
    return;
  }
  const auto frame = decode_payload(bits, start, *codec_);
  if (frame.ok()) {
    cycle.frame = *frame;
  } else {
    cycle.status = status_of(frame.error().cause);
  }
  note_checksums(frame.ok() ? std::nullopt : std::optional(frame.error()), cycle);
  reading.complete = frame.ok() || frame.error().cause != FrameError::truncated;
}

// Notes the result of decode_payload(), and checks the channels that it did not reach.
void CycleReader::note_checksums(const std::optional<FrameFault>& fault, Cycle& cycle) const {
  const BitView raw = cycle.raw.view();
  const auto channels = codec_->format().channels();
  const bool wrong = fault && fault->cause == FrameError::crc;
  const bool all_right = !fault || fault->cause == FrameError::stop_bit;
  const std::size_t right = all_right ? channels.size() : wrong ? fault->channel : 0;
  std::size_t at = 2;
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const ChannelFormat& channel = channels[k];
    if (at + channel.total_bits() > raw.size_bits()) return;
    if (channel.crc.present()) {
      cycle.crc_ok[k] = k < right || (!(wrong && k == right) &&
                                      raw.word(at + channel.data_bits, channel.crc.width_bits) ==
                                          codec_->crc(k, raw.word(at, channel.data_bits), raw[1]));
    }
    at += channel.total_bits();
  }
}

// Long intervals of MA are pauses, and not clocks that the capture lost: the frame is right to its
// STOP, or the encoder has waited. A lost clock would often show as a change of SLO in the pause.
bool CycleReader::pauses_are_certain(const CycleSpan& span, const LineHistory& slo,
                                     Picoseconds delay, std::size_t last_bit, Cycle& cycle) const {
  if (clock_.first_early <= last_bit) return false;
  if (span.usual_clocks != 0 && clock_.rises.size() != span.usual_clocks) return false;
  bool waited = knows_timeout();
  for (std::size_t i = clock_.first_irregular; i <= last_bit; ++i) {
    const Picoseconds interval = clock_.intervals[i - 1];
    if (!irregular(interval, clock_.period)) continue;
    const std::size_t change =
        slo.after(shifted(clock_.rises[i - 1], delay + clock_.period * 3 / 4));
    if (change < slo_end_ && slo[change].time < shifted(clock_.rises[i], delay - clock_.period / 4))
      return false;
    waited = waited && outlasts(interval - clock_.period / 2);
    ++cycle.pauses;
    cycle.longest_pause = std::max(cycle.longest_pause, interval - clock_.period);
  }
  const bool right = checked_payload_bits() && cycle.frame && cycle.frame->stop_seen;
  return right || waited;
}

// Whether the encoder certainly still takes a clock that comes this long after the previous edge.
bool CycleReader::outlasts(Picoseconds pause) const {
  if (timing_.timeout.rule == TimeoutRule::adaptive) return 2 * pause < 3 * clock_.period;
  if (timing_.timeout.rule == TimeoutRule::fixed) return pause < timing_.timeout.time;
  return elapsed(clock_.rises.front(), clock_.rises.back()) < timing_.timeout.time;
}

std::optional<std::size_t> CycleReader::checked_payload_bits() const {
  if (!codec_) return std::nullopt;
  const auto channels = codec_->format().channels();
  const bool checked = std::any_of(channels.begin(), channels.end(),
                                   [](const ChannelFormat& each) { return each.crc.present(); });
  return checked ? std::optional(codec_->payload_bits()) : std::nullopt;
}

// The faults that only a capture can show, and the faults that explain more than the bits do.
std::optional<CycleStatus> CycleReader::fault_of_capture(const CycleSpan& span,
                                                         const Sampled& sampled,
                                                         CycleStatus status) const {
  const bool bits_missing = status == CycleStatus::no_start || status == CycleStatus::truncated;
  if (!bits_missing) return std::nullopt;
  if (sampled.reached_unknown) return CycleStatus::unknown_level;
  if (!span.last_of_capture) return std::nullopt;
  const Picoseconds last_rise = clock_.rises.back();
  const Picoseconds idle = elapsed(last_rise, std::max(last_rise, span.limit));
  if (sampled.reached_limit || idle * 2 < clock_.period * 3) return CycleStatus::cut_end;
  return std::nullopt;
}

}  // namespace biss::decode
