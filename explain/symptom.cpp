#include "explain/symptom.hpp"

#include <algorithm>

#include "decode/intervals.hpp"
#include "decode/times.hpp"

namespace biss::explain {

namespace {

using decode::Cycle;
using decode::CycleEdges;
using decode::CycleStatus;
using decode::LevelChange;
using wire::Level;

// A level of MA shorter than this share of its usual length is a pulse, in per cent.
constexpr std::int64_t ma_pulse_percent = 40;
// A level of SLO shorter than a period over this is a pulse: a bit lasts a period.
constexpr std::int64_t slo_pulse_share = 4;
// A change of SLO further from its place than a period over this is smeared.
constexpr std::int64_t smear_share = 5;
// As many changes in a wrong place are a clock too many at the encoder, not a smeared signal.
constexpr unsigned stray_changes = 2;
// Bits at the end of a frame that are all alike by more than chance.
constexpr std::size_t high_tail_bits = 5;
constexpr std::size_t low_tail_bits = 10;

std::vector<Picoseconds> lengths_of(std::span<const LevelChange> changes, Level level) {
  std::vector<Picoseconds> lengths;
  for (std::size_t i = 0; i + 1 < changes.size(); ++i) {
    if (changes[i].level == level) {
      lengths.push_back(decode::elapsed(changes[i].time, changes[i + 1].time));
    }
  }
  return lengths;
}

std::vector<Picoseconds> rises_of(std::span<const LevelChange> ma) {
  std::vector<Picoseconds> rises;
  for (const LevelChange& change : ma) {
    if (change.level == Level::high) rises.push_back(change.time);
  }
  return rises;
}

std::uint16_t ack_clocks_of(const Cycle& cycle) {
  if (cycle.frame) return cycle.frame->ack_clocks;
  if (!cycle.ack || !cycle.period) return 0;
  return static_cast<std::uint16_t>((cycle.ack->count + cycle.period->count / 2) /
                                    cycle.period->count);
}

std::size_t tail_of(BitView bits, bool level) {
  std::size_t tail = 0;
  while (tail < bits.size_bits() && bits[bits.size_bits() - 1 - tail] == level) ++tail;
  return tail;
}

// The fewest bits that differ where `bits` follow `reference` up to a bit, and from there on the
// reference shifted by `shift`.
std::size_t best_slip(BitView bits, BitView reference, std::ptrdiff_t shift) {
  const auto size = static_cast<std::ptrdiff_t>(bits.size_bits());
  const auto differs = [&](std::ptrdiff_t at, std::ptrdiff_t by) {
    const std::ptrdiff_t other = std::clamp<std::ptrdiff_t>(at + by, 0, size - 1);
    return bits[static_cast<std::size_t>(at)] != reference[static_cast<std::size_t>(other)] ? 1U
                                                                                            : 0U;
  };
  std::size_t sum = 0;
  for (std::ptrdiff_t at = 0; at < size; ++at) sum += differs(at, shift);
  std::size_t best = sum;
  for (std::ptrdiff_t at = 0; at < size; ++at) {
    sum += differs(at, 0);
    sum -= differs(at, shift);
    best = std::min(best, sum);
  }
  return best;
}

// A line delay that is off by this, in thousandths of a period: far, half a period, a clock.
bool is_far(std::int64_t off) { return off > 300 || off < -300; }
bool is_half(std::int64_t off) { return (off > 450 && off < 550) || (off > -550 && off < -450); }
bool is_whole(std::int64_t off) { return (off > 900 && off < 1100) || (off > -1100 && off < -900); }

}  // namespace

std::string_view text_of(Symptom symptom) {
  constexpr std::array<std::string_view, symptom_count> symptom_texts{
      "good",
      "a good frame reports an error (nE = 0)",
      "the sign of life of a good frame is not one more than before",
      "a pulse on MA",
      "an edge of MA is missing or too many",
      "a pulse on SLO",
      "SLO stays high",
      "SLO is low at the request and rises later",
      "SLO is low from the request to the next one",
      "SLO rests low and goes high with ACK, as an inverted SLO does",
      "SLO changes half a period early, with the falling edges of MA",
      "SLO falls before the edge of ACK",
      "MA stops in ACK, or START comes too late for the clocks of the master",
      "MA stops before the last bit of the frame",
      "START is outside the encoder's bounds",
      "CDS is 1 where the format says 0",
      "STOP is 1 after right checksums",
      "ACK comes clocks later than usual",
      "SLO stays high from a bit on to STOP",
      "SLO stays low from a bit on to STOP",
      "SLO changes far from its place in a bit",
      "the line delay changes",
      "bits are shifted by a clock",
      "the checksum is wrong"};
  return symptom_texts[static_cast<std::size_t>(symptom)];
}

SymptomReader::SymptomReader(const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                             const decode::MarginSetup& margin)
    : format_(format),
      again_(format, timing, margin),
      resolution_(margin.resolution),
      tallies_(margin.resolution),
      sequence_(format, timing, 0, tallies_) {
  if (!format) return;
  const auto channels = format->channels();
  has_sign_of_life_ = std::any_of(channels.begin(), channels.end(), [](const ChannelFormat& each) {
    return each.life_counter.present();
  });
}

Symptom SymptomReader::read(const CycleEdges& edges) {
  const Cycle& cycle = edges.cycle;
  marks_ = mark(edges);
  life_jumps_ = life_jumps(edges);
  rest_before_.reset();
  if (last_edge_ && *last_edge_ <= cycle.time) {
    rest_before_ = decode::elapsed(*last_edge_, cycle.time);
  }
  if (!edges.ma.empty()) last_edge_ = edges.ma.back().time;
  const Symptom symptom = cycle.status == CycleStatus::ma_glitch || marks_.ma_pulses != 0
                              ? Symptom::ma_pulse
                              : of_status(edges);
  if (is_good(cycle.status) && marks_.ma_pulses + marks_.slo_pulses == 0) learn(cycle);
  return symptom;
}

LineMarks SymptomReader::mark(const CycleEdges& edges) const {
  LineMarks marks;
  mark_ma(edges, marks);
  mark_slo(edges, marks);
  return marks;
}

void SymptomReader::mark_ma(const CycleEdges& edges, LineMarks& marks) const {
  for (const Level level : {Level::low, Level::high}) {
    std::vector<Picoseconds> lengths = lengths_of(edges.ma, level);
    if (lengths.size() < 4) continue;
    std::vector<Picoseconds> sorted = lengths;
    const Picoseconds usual = decode::median(sorted);
    for (const Picoseconds length : lengths_of(edges.ma_after, level)) lengths.push_back(length);
    for (const Picoseconds length : lengths) {
      if (100 * length >= ma_pulse_percent * usual) continue;
      if (usual - length <= 3 * resolution_) continue;
      ++marks.ma_pulses;
      marks.shortest_pulse = std::min(length, marks.shortest_pulse.value_or(length));
    }
  }
}

void SymptomReader::mark_slo(const CycleEdges& edges, LineMarks& marks) const {
  const Cycle& cycle = edges.cycle;
  const auto slo = edges.slo;
  if (edges.slo_before == Level::low) {
    const auto rise = std::find_if(slo.begin(), slo.end(), [](const LevelChange& change) {
      return change.level == Level::high;
    });
    if (rise != slo.end()) marks.rise = decode::elapsed(cycle.time, rise->time);
  }
  if (!cycle.period) return;
  const Picoseconds period = *cycle.period;
  for (std::size_t i = 0; i + 1 < slo.size(); ++i) {
    const Picoseconds length = decode::elapsed(slo[i].time, slo[i + 1].time);
    if (slo_pulse_share * (length + 2 * resolution_) >= period) continue;
    ++marks.slo_pulses;
    marks.shortest_pulse = std::min(length, marks.shortest_pulse.value_or(length));
  }
  if (!cycle.line_delay) return;
  const std::vector<Picoseconds> rises = rises_of(edges.ma);
  if (rises.size() < 3) return;
  const Picoseconds last = decode::shifted(rises.back(), *cycle.line_delay + period / 2);
  for (const LevelChange& change : slo) {
    const Picoseconds moved_at = decode::shifted(change.time, -*cycle.line_delay);
    if (moved_at < rises[1] || change.time > last) continue;
    const auto after = std::lower_bound(rises.begin(), rises.end(), moved_at);
    Picoseconds off = after == rises.end() ? moved_at - rises.back() : *after - moved_at;
    if (after != rises.begin()) off = std::min(off, moved_at - *(after - 1));
    marks.smear = std::max(marks.smear, off);
    if (smear_share * off > period + 2 * smear_share * cycle.uncertainty) ++marks.smeared_changes;
  }
}

Symptom SymptomReader::of_status(const CycleEdges& edges) {
  const Cycle& cycle = edges.cycle;
  switch (cycle.status) {
    case CycleStatus::cut_start:
    case CycleStatus::cut_end:
    case CycleStatus::unknown_level:
      return Symptom::none;
    case CycleStatus::ok:
    case CycleStatus::unchecked:
      return marks_.slo_pulses != 0 ? Symptom::slo_pulse : of_good(cycle);
    case CycleStatus::ma_clock:
      return Symptom::ma_uneven;
    case CycleStatus::not_ready:
      return of_low_request(edges);
    case CycleStatus::no_response:
      return edges.slo_before == Level::low ? of_low_request(edges) : Symptom::silent;
    case CycleStatus::response_range:
      return edges.slo_before == Level::low ? of_low_request(edges) : of_early(edges);
    default:
      break;
  }
  const auto off = delay_off(cycle);
  if (off && *off > 1500) return Symptom::late_answer;
  if (marks_.slo_pulses != 0) return Symptom::slo_pulse;
  if (cycle.status == CycleStatus::no_start) return Symptom::cut_in_ack;
  const bool short_of_bits =
      format_ && cycle.raw.view().size_bits() < std::size_t{2} + format_->payload_bits();
  if (cycle.status == CycleStatus::truncated ||
      (cycle.status == CycleStatus::ack_range && short_of_bits)) {
    return of_short(edges);
  }
  return of_bits(edges);
}

// SLO is low where the request begins.
Symptom SymptomReader::of_low_request(const CycleEdges& edges) {
  if (answers_inverted(edges)) return Symptom::inverted;
  // As long a rest was enough before.
  const bool rested = rest_before_ && shortest_rest_ && *rest_before_ >= *shortest_rest_;
  return marks_.rise && !rested ? Symptom::busy : Symptom::stuck;
}

// Whether SLO, inverted, answers this request. A master that sees SLO inverted may stop before the
// frame: SLO then shows ACK alone, and goes back to the level at which it rests.
bool SymptomReader::answers_inverted(const CycleEdges& edges) {
  const Cycle other = read_again(edges, again_, true).cycle;
  if (!other.line_delay || !other.period) return false;
  const auto off = delay_off(other);
  const bool in_time = *other.line_delay < 2 * *other.period || (off && !is_far(*off));
  if (is_good(other.status)) return *other.line_delay < 8 * *other.period;
  const bool rests_low = !edges.slo.empty() && edges.slo.back().level == Level::low;
  return in_time && rests_low && marks_.slo_pulses == 0;
}

// SLO fell before the edge of ACK, or far too late.
Symptom SymptomReader::of_early(const CycleEdges& edges) const {
  const Cycle& cycle = edges.cycle;
  if (!cycle.early || !cycle.period) return Symptom::late_answer;
  if (marks_.slo_pulses != 0) return Symptom::slo_pulse;
  return 100 * *cycle.early <= 60 * *cycle.period ? Symptom::half_early : Symptom::early;
}

// MA stopped before the last bit of the format.
Symptom SymptomReader::of_short(const CycleEdges& edges) const {
  const Cycle& cycle = edges.cycle;
  const bool late = longest_ack_ != 0 && ack_clocks_of(cycle) > longest_ack_;
  if (late) return Symptom::cut_in_ack;
  // Of a frame that the master did not end, ones at the end are data.
  if (cycle.rising_edges < fewest_clocks_) return Symptom::cut_short;
  return tail_of(cycle.raw.view(), true) >= high_tail_bits ? Symptom::tail_high
                                                           : Symptom::cut_short;
}

// All bits are there and something about them is wrong.
Symptom SymptomReader::of_bits(const CycleEdges& edges) const {
  const Cycle& cycle = edges.cycle;
  const BitView raw = cycle.raw.view();
  const auto off = delay_off(cycle);
  if (off && is_half(*off)) return Symptom::half_early;
  if (cycle.status == CycleStatus::stop_bit) return Symptom::stop_high;
  if (tail_of(raw, true) >= high_tail_bits) return Symptom::tail_high;
  if (tail_of(raw, false) >= low_tail_bits &&
      tail_of(last_good_.view(), false) + 4 < tail_of(raw, false)) {
    return Symptom::tail_low;
  }
  if (marks_.smeared_changes > stray_changes) return Symptom::smeared;
  if (marks_.smeared_changes != 0) return Symptom::slipped;
  if (off && is_far(*off)) return is_whole(*off) ? Symptom::slipped : Symptom::smeared;
  const bool wrong = std::any_of(cycle.crc_ok.begin(), cycle.crc_ok.end(),
                                 [](const auto& right) { return right == false; });
  if (cycle.status == CycleStatus::ack_range && !wrong) return Symptom::other_ack;
  if (cycle.status == CycleStatus::cds && !wrong) return Symptom::cds_high;
  return slips(cycle) ? Symptom::slipped : Symptom::flipped;
}

Symptom SymptomReader::of_good(const Cycle& cycle) const {
  if (cycle.frame && !cycle.frame->trusted()) return Symptom::error_flag;
  if (life_jumps_) return Symptom::life_jump;
  const auto off = delay_off(cycle);
  if (!off || !is_far(*off)) return Symptom::none;
  if (is_half(*off)) return Symptom::half_early;
  return is_whole(*off) ? Symptom::slipped : Symptom::delay_changed;
}

bool SymptomReader::life_jumps(const CycleEdges& edges) {
  if (!has_sign_of_life_) return false;
  const auto faults = [this] { return tallies_.result(decode::Rule::sign_of_life).faults; };
  const std::uint64_t before = faults();
  sequence_.push(edges.number, edges.cycle);
  return faults() != before;
}

// Whether the frame is the last good one with a bit lost or doubled: much more like it than without.
bool SymptomReader::slips(const Cycle& cycle) const {
  const BitView raw = cycle.raw.view();
  const BitView good = last_good_.view();
  if (raw.size_bits() != good.size_bits() || raw.size_bits() < 8) return false;
  std::size_t direct = 0;
  for (std::size_t i = 0; i < raw.size_bits(); ++i) direct += raw[i] != good[i] ? 1U : 0U;
  const std::size_t slipped = std::min(best_slip(raw, good, 1), best_slip(raw, good, -1));
  return slipped + 4 <= direct && slipped <= 2 + raw.size_bits() / 12;
}

// The line delay less the usual one, in thousandths of a period.
std::optional<std::int64_t> SymptomReader::delay_off(const Cycle& cycle) const {
  if (!usual_delay_ || !cycle.line_delay || !cycle.period) return std::nullopt;
  const Picoseconds doubt = 2 * cycle.uncertainty;
  Picoseconds off = *cycle.line_delay - *usual_delay_;
  off = off.count > 0 ? std::max(Picoseconds{}, off - doubt) : std::min(Picoseconds{}, off + doubt);
  return 1000 * off.count / cycle.period->count;
}

void SymptomReader::learn(const Cycle& cycle) {
  longest_ack_ = std::max(longest_ack_, ack_clocks_of(cycle));
  last_good_ = cycle.raw;
  fewest_clocks_ = std::min(fewest_clocks_, cycle.rising_edges);
  if (rest_before_)
    shortest_rest_ = std::min(*rest_before_, shortest_rest_.value_or(*rest_before_));
  if (!cycle.line_delay) return;
  const auto off = delay_off(cycle);
  if (!off || (*off < 200 && *off > -200)) usual_delay_ = cycle.line_delay;
}

}  // namespace biss::explain
