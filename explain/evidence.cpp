#include "explain/evidence.hpp"

#include <algorithm>

#include "biss/crc/engines.hpp"
#include "decode/times.hpp"

namespace biss::explain {

namespace {

using decode::Cycle;
using decode::CycleEdges;
using decode::CycleStatus;

// A gap is a multiple of the step within a share of the step.
constexpr std::int64_t grid_tolerance = 12;
// Gaps longer than this many steps say nothing about the step.
constexpr std::int64_t grid_steps = 40;

unsigned crc_bits_of(const FrameFormat& format) {
  unsigned bits = 0;
  for (const ChannelFormat& channel : format.channels()) bits += channel.crc.width_bits;
  return bits;
}

bool is_cut(CycleStatus status) {
  return status == CycleStatus::cut_start || status == CycleStatus::cut_end;
}

std::int64_t clocks_in(Picoseconds time, Picoseconds period) {
  return (time.count + period.count / 2) / period.count;
}

bool lies_on(Picoseconds gap, Picoseconds step) {
  const std::int64_t off = (gap.count + step.count / 2) % step.count - step.count / 2;
  return grid_tolerance * std::max(off, -off) <= step.count;
}

void add(Sightings& seen, const CycleEdges& edges) {
  if (seen.count++ == 0) {
    seen.first_cycle = edges.number;
    seen.first_time = edges.cycle.time;
  }
  seen.last_cycle = edges.number;
}

bool warns(const Frame& frame) {
  const auto channels = frame.channels();
  return std::any_of(channels.begin(), channels.end(), [](const auto& each) { return !each.nW; });
}

// Which usual checksums a frame from START to STOP has: bit k of the result is that of number k.
unsigned usual_checksums(BitView raw) {
  constexpr std::array<std::uint8_t, 4> widths{5, 6, 8, 16};
  unsigned fitting = 0;
  for (std::size_t k = 0; k < widths.size(); ++k) {
    const std::size_t width = widths[k];
    if (raw.size_bits() < width + 4 || raw.size_bits() > width + 3 + max_data_bits) continue;
    const std::size_t data_bits = raw.size_bits() - width - 3;
    const CrcBitwise crc({.polynomial = default_polynomial(widths[k]), .width_bits = widths[k]});
    const std::uint64_t data = raw.word(2, static_cast<unsigned>(data_bits));
    if (raw.word(2 + data_bits, widths[k]) == crc(data, static_cast<unsigned>(data_bits))) {
      fitting |= 1U << k;
    }
  }
  return fitting;
}

}  // namespace

void SampleGrid::push(wire::Edge edge, wire::LineIndex ma) {
  if (gaps_.size() < gaps_kept) {
    if (last_ && *last_ < edge.time) gaps_.push_back(decode::elapsed(*last_, edge.time));
    last_ = edge.time;
    if (edge.line != ma) ++slo_edges_;
  }
  if (edge.line != ma) return;
  auto& levels = ma_levels_[edge.level == wire::Level::high ? 0 : 1];
  if (last_ma_ && levels.size() < gaps_kept / 2) {
    levels.push_back(decode::elapsed(*last_ma_, edge.time));
  }
  last_ma_ = edge.time;
}

// A level of a clock that is sampled lasts a step more at times.
bool SampleGrid::varies_by(Picoseconds step) const {
  bool varies = false;
  for (const auto& levels : ma_levels_) {
    std::array<std::size_t, 8> lengths{};
    std::size_t all = 0;
    for (const Picoseconds level : levels) {
      const std::int64_t steps = clocks_in(level, step);
      if (steps >= 8) continue;
      ++lengths[static_cast<std::size_t>(steps)];
      ++all;
    }
    const auto occurs = [&](std::size_t steps) {
      return lengths[steps] >= 3 && 400 * lengths[steps] > all;
    };
    if ((occurs(1) && occurs(2)) || (occurs(2) && occurs(3))) varies = true;
    // Levels of many different lengths are data, for example of a UART.
    if (25 * (lengths[4] + lengths[5] + lengths[6] + lengths[7]) >= all + 1) return false;
  }
  return varies;
}

std::optional<Picoseconds> SampleGrid::step() const {
  if (gaps_.size() < 64 || ma_levels_[0].size() < 16 || slo_edges_ < 16) return std::nullopt;
  const Picoseconds step = *std::min_element(gaps_.begin(), gaps_.end());
  std::size_t on = 0;
  std::size_t judged = 0;
  for (const Picoseconds gap : gaps_) {
    if (gap > grid_steps * step) continue;
    ++judged;
    if (lies_on(gap, step)) ++on;
  }
  if (judged < 64 || 100 * on < 97 * judged || !varies_by(step)) return std::nullopt;
  return step;
}

Observer::Observer(const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                   const decode::MarginSetup& margin, const decode::Lines& lines)
    : lines_(lines),
      symptoms_(format, timing, margin),
      cycles_(decode::CycleReader(format, timing, margin), lines,
              [this](const CycleEdges& edges) { take(edges); }) {
  evidence_.resolution = margin.resolution;
  evidence_.has_format = format.has_value();
  if (!format) return;
  evidence_.crc_bits = crc_bits_of(*format);
  evidence_.payload_bits = format->payload_bits();
}

void Observer::push(std::span<const wire::Edge> edges) {
  for (const wire::Edge& edge : edges) {
    const bool ma = edge.line == lines_.ma;
    if (!ma && edge.line != lines_.slo) continue;
    ++(ma ? evidence_.ma_edges : evidence_.slo_edges);
    grid_.push(edge, lines_.ma);
  }
  cycles_.push(edges);
}

const Evidence& Observer::finish(Picoseconds end_time) {
  cycles_.finish(end_time);
  settle();
  return evidence_;
}

void Observer::take(const CycleEdges& edges) {
  const Cycle& cycle = edges.cycle;
  if (wanted_ && !wanted_(cycle)) return;
  ++evidence_.statuses[static_cast<std::size_t>(cycle.status)];
  const Symptom symptom = symptoms_.read(edges);
  if (is_cut(cycle.status)) return;
  ++evidence_.cycles;
  if (is_good(cycle.status)) ++evidence_.good;
  note(symptom, edges);
  note_frame(cycle);
  note_times(edges, is_good(cycle.status) && symptom == Symptom::none);
}

void Observer::note(Symptom symptom, const CycleEdges& edges) {
  add(evidence_.symptoms[static_cast<std::size_t>(symptom)], edges);
  if (edges.cycle.frame && warns(*edges.cycle.frame)) add(evidence_.warnings, edges);
  const LineMarks& marks = symptoms_.marks();
  evidence_.pulses_on_ma += marks.ma_pulses;
  evidence_.pulses_on_slo += marks.slo_pulses;
  if (marks.shortest_pulse) {
    evidence_.shortest_pulse =
        std::min(*marks.shortest_pulse, evidence_.shortest_pulse.value_or(*marks.shortest_pulse));
  }
  if (symptom != Symptom::ma_pulse && symptom != Symptom::slo_pulse) {
    evidence_.smear = std::max(evidence_.smear, marks.smear);
  }
  silence_ = symptom == Symptom::silent ? silence_ + 1 : 0;
  if (silence_ == 1) ++evidence_.silent_runs;
  evidence_.longest_silence = std::max(evidence_.longest_silence, silence_);
}

void Observer::note_frame(const Cycle& cycle) {
  if (cycle.ack && cycle.line_delay) ++evidence_.answered;
  if (is_good(cycle.status)) ++evidence_.passed;
  const bool short_of_bits = cycle.status == CycleStatus::ack_range &&
                             cycle.raw.view().size_bits() < std::size_t{2} + evidence_.payload_bits;
  if (cycle.status == CycleStatus::truncated || short_of_bits) note_truncated(cycle);
  const BitView raw = cycle.raw.view();
  if (cycle.frame && raw.size_bits() == evidence_.payload_bits + 3U) {
    const bool last = raw[raw.size_bits() - 2];
    last_crc_bit_changes_ = last_crc_bit_changes_ || (last_crc_bit_ && *last_crc_bit_ != last);
    last_crc_bit_ = last;
  }
  if (cycle.status == CycleStatus::stop_bit && raw[raw.size_bits() - 2]) {
    ++evidence_.stops_like_last_bit;
  }
  if (cycle.status != CycleStatus::crc || raw.size_bits() < 4) return;
  if (raw.size_bits() < evidence_.payload_bits + 3U) return;
  ++evidence_.failed_checks;
  if (!raw[raw.size_bits() - 2]) ++evidence_.last_bit_low;
  if (raw[raw.size_bits() - 1]) ++evidence_.stop_high;
}

void Observer::note_truncated(const Cycle& cycle) {
  const BitView raw = cycle.raw.view();
  ++evidence_.truncated;
  if (cycle.ack && cycle.period) {
    evidence_.truncated_ack_clocks.add(clocks_in(*cycle.ack, *cycle.period));
  }
  if (evidence_.payload_bits + 2U > raw.size_bits()) {
    evidence_.missing_bits.add(
        static_cast<std::int64_t>(evidence_.payload_bits + 2U - raw.size_bits()));
  }
  if (raw.size_bits() < 4) return;
  if (!raw[raw.size_bits() - 1]) ++evidence_.truncated_low;
  fitting_checksums_ &= usual_checksums(raw);
  evidence_.usual_checksum = fitting_checksums_ != 0;
  const bool before = raw[raw.size_bits() - 2];
  if (bit_before_last_ && *bit_before_last_ != before) evidence_.before_last_changes = true;
  bit_before_last_ = before;
}

void Observer::note_times(const CycleEdges& edges, bool good) {
  const Cycle& cycle = edges.cycle;
  evidence_.rising_edges.add(static_cast<std::int64_t>(cycle.rising_edges));
  if (cycle.period) evidence_.period.add(cycle.period->count);
  if (cycle.ack) evidence_.ack.add(cycle.ack->count);
  if (cycle.early) evidence_.early.add(cycle.early->count);
  if (cycle.marginal) {
    ++evidence_.margin_judged;
    if (*cycle.marginal) ++evidence_.marginal;
  }
  if (cycle.line_delay) {
    evidence_.line_delay.add(cycle.line_delay->count);
    if (!first_delay_) first_delay_ = cycle.line_delay;
    const Picoseconds off = *cycle.line_delay - *first_delay_;
    if (cycle.period && 2 * std::max(off, -off) >= *cycle.period) ++evidence_.far_delays;
  }
  if (const auto rest = symptoms_.rest_before()) {
    (good ? evidence_.good_rest : evidence_.rest_of_bad).add(rest->count);
  }
  if (!good) return;
  if (cycle.release) evidence_.release.add(cycle.release->count);
  if (!cycle.ack || !cycle.period) return;
  const std::int64_t ack_clocks = clocks_in(*cycle.ack, *cycle.period);
  evidence_.ack_clocks.add(ack_clocks);
  if (!cycle.frame) return;
  const std::int64_t needed = 1 + ack_clocks + 3 + std::int64_t{evidence_.payload_bits};
  evidence_.extra_clocks.add(std::int64_t{cycle.rising_edges} - needed);
}

// What only the whole capture shows.
void Observer::settle() {
  const auto move = [this](Symptom from, Symptom to) {
    Sightings& source = evidence_.symptoms[static_cast<std::size_t>(from)];
    Sightings& target = evidence_.symptoms[static_cast<std::size_t>(to)];
    if (source.count == 0) return;
    if (target.count == 0 || source.first_cycle < target.first_cycle) {
      target.first_cycle = source.first_cycle;
      target.first_time = source.first_time;
    }
    target.count += source.count;
    target.last_cycle = std::max(target.last_cycle, source.last_cycle);
    source = {};
  };
  if (evidence_.resolution.count == 0) {
    evidence_.resolution = grid_.step().value_or(Picoseconds{});
  }
  // An encoder that counted a clock too many sends STOP where the last bit is expected; one that
  // missed a clock sends the last bit where STOP is expected.
  const std::uint64_t failed = evidence_.failed_checks;
  if (last_crc_bit_changes_ && (failed >= 5 || evidence_.stop_high != 0)) {
    const std::uint64_t low = evidence_.last_bit_low;
    const bool slips = failed < 10
                           ? low == failed || evidence_.stop_high != 0
                           : 100 * low >= 85 * failed || 100 * evidence_.stop_high >= 15 * failed;
    slips ? move(Symptom::flipped, Symptom::slipped) : move(Symptom::slipped, Symptom::flipped);
  }
  // START came later than in any good cycle, but before the first good one.
  const auto& late = evidence_.truncated_ack_clocks;
  const auto& usual = evidence_.ack_clocks;
  if (late.count() != 0 && usual.count() != 0 && late.min() > usual.max()) {
    move(Symptom::cut_short, Symptom::cut_in_ack);
  }
}

}  // namespace biss::explain
