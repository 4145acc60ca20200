// Protocols with a clock in bursts: SSI, EnDat, SPI, and a clock that nothing answers.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <set>

#include "biss/base/bit_buffer.hpp"
#include "biss/crc/engines.hpp"
#include "identify/protocol_lines.hpp"

namespace biss::identify {

namespace {

// ---- A clock and a line of data, burst by burst

constexpr double microsecond = 1e6;

/// The data of one burst of the clock.
struct Transfer {
  std::size_t pulses = 0;
  /// The level of the data when the clock starts, and a period after its last edge.
  bool before = false;
  bool after = false;
  /// Data changes with the first pulse of the clock.
  bool starts = false;
  /// Data changes from here to the next burst.
  bool moves = false;
  /// Changes of the data in the gap after the burst, and from the end of the burst to the first one
  /// and to the last one.
  std::size_t gap_changes = 0;
  double release = 0;
  double recovery = 0;
};

/// A clock and a line of data.
struct Pair {
  const Trace& line;
  const ClockShape& clock;
  const Trace& data;
  /// The data is held from before each burst to after it.
  bool selects = false;
  /// Changes of data per burst, and how far they keep to one phase of the clock: 0 to 1.
  double changes = 0;
  double coherence = 0;
  /// The usual phase, in periods after the clock's return to idle: -0.5 to 0.5.
  double phase = 0;
  std::vector<Transfer> transfers;

  Picoseconds begin_of(const Burst& burst) const { return line.changes[burst.first]; }
  Picoseconds end_of(const Burst& burst) const { return line.changes[burst.last]; }
  /// The time `periods` after the return of the clock to idle after pulse `k`.
  Picoseconds return_of(const Burst& burst, std::size_t k, double periods) const {
    return later(line.changes[burst.first + 2 * k + 1], periods * clock.period);
  }
};

bool is_select(const Pair& pair) {
  const std::vector<Burst>& bursts = pair.clock.bursts;
  const std::size_t changes = pair.data.changes.size();
  if (changes < 4 || changes > 2 * bursts.size() + 2) return false;
  std::size_t held = 0;
  std::size_t high = 0;
  for (const Burst& burst : bursts) {
    const std::size_t at = pair.data.after(pair.begin_of(burst));
    if (pair.data.after(pair.end_of(burst)) != at) continue;
    ++held;
    high += pair.data.level_before(at) ? 1U : 0U;
  }
  return 10 * std::max(high, held - high) >= 9 * bursts.size();
}

// The place in a period at which the data changes: the mean direction, with a full turn for a
// period, from the edges that leave the idle level and from the edges that return to it.
void measure_phase(Pair& pair) {
  constexpr double turn = 2 * std::numbers::pi;
  const auto& clock = pair.line.changes;
  std::array<std::complex<double>, 2> sums;
  std::size_t count = 0;
  for (const Burst& burst : pair.clock.bursts) {
    const Picoseconds stop = later(pair.end_of(burst), 0.9 * pair.clock.period);
    std::size_t edge = burst.first;
    for (std::size_t i = pair.data.after(pair.begin_of(burst)); i < pair.data.changes.size(); ++i) {
      const Picoseconds time = pair.data.changes[i];
      if (time > stop) break;
      while (edge + 1 <= burst.last && clock[edge + 1] <= time) ++edge;
      const std::size_t returns = (edge - burst.first) % 2;
      const std::size_t other = edge == burst.first ? edge + 1 : edge - 1;
      sums[returns] += std::polar(1.0, turn * offset(clock[edge], time) / pair.clock.period);
      sums[1 - returns] += std::polar(1.0, turn * offset(clock[other], time) / pair.clock.period);
      ++count;
    }
  }
  if (count == 0) return;
  pair.coherence = std::max(std::abs(sums[0]), std::abs(sums[1])) / static_cast<double>(count);
  pair.phase = std::arg(sums[1]) / turn;
  pair.changes = share(count, pair.clock.bursts.size());
}

Transfer read_transfer(const Pair& pair, std::size_t index, Picoseconds capture_end) {
  const std::vector<Burst>& bursts = pair.clock.bursts;
  const Trace& data = pair.data;
  const Burst& burst = bursts[index];
  const Picoseconds begin = pair.begin_of(burst);
  const Picoseconds end = pair.end_of(burst);
  const double period = pair.clock.period;
  const auto changes = [&](Picoseconds from, Picoseconds to) {
    return data.after(from) < data.after(to);
  };
  const bool is_last = index + 1 == bursts.size();
  const Picoseconds next =
      is_last ? capture_end : later(pair.begin_of(bursts[index + 1]), -0.1 * period);
  const double delay = pair.phase < -0.25 ? pair.phase + 1 : std::max(pair.phase, 0.0);
  const Picoseconds settled = later(end, (delay + 0.3) * period);
  Transfer transfer{.pulses = burst.pulses(),
                    .before = data.level_at(later(begin, -0.1 * period)),
                    .after = data.level_at(std::min(settled, next)),
                    .starts = changes(begin, pair.return_of(burst, 0, 0.85)),
                    .moves = changes(begin, next)};
  if (changes(settled, next)) {
    const std::size_t first = data.after(settled);
    const std::size_t last = data.after(next) - 1;
    transfer.gap_changes = last - first + 1;
    transfer.release = length(end, data.changes[first]);
    transfer.recovery = length(end, data.changes[last]);
  }
  return transfer;
}

Pair read_pair(const Scene& scene, const Trace& clock, const Trace& data) {
  constexpr std::size_t bursts_used = 400;
  Pair pair{.line = clock, .clock = clock.clock, .data = data, .transfers = {}};
  pair.selects = is_select(pair);
  measure_phase(pair);
  for (std::size_t i = 0; i < std::min(clock.clock.bursts.size(), bursts_used); ++i) {
    pair.transfers.push_back(read_transfer(pair, i, scene.end));
  }
  return pair;
}

using Bits = BitBuffer<512>;

// The level of the data in each burst, `phase` periods after each return of the clock to idle.
std::vector<Bits> words_at(const Pair& pair, double phase, bool inverted) {
  std::vector<Bits> words(pair.transfers.size());
  for (std::size_t i = 0; i < words.size(); ++i) {
    const Burst& burst = pair.clock.bursts[i];
    const std::size_t count = std::min(burst.pulses(), Bits::capacity_bits);
    for (std::size_t k = 0; k < count; ++k) {
      words[i].append(pair.data.level_at(pair.return_of(burst, k, phase)) != inverted);
    }
  }
  return words;
}

// ---- SSI

// Data rests at one level, then a bit with each return of the clock to idle, then the other level
// for a fixed time. If several words follow one another, only the first one begins at rest.
void try_ssi(const Pair& pair, const BissTrial& biss, Guesses& guesses) {
  constexpr std::size_t longest = 40;
  const std::vector<Transfer>& transfers = pair.transfers;
  const std::size_t pulses = pair.clock.usual_pulses;
  if (pulses < 9 || pulses > 8 * longest || pair.coherence < 0.75) return;
  if (share_of(transfers, [&](const Transfer& t) { return t.pulses % pulses == 0; }) < 0.8) return;
  // The probe may show either line inverted: data rests at the level it has before the longest gaps.
  const double same =
      share_of(transfers, [&](const Transfer& t) { return t.before == pair.clock.idle_high; });
  const bool level = pair.clock.idle_high == (same >= 1.0 / 3);
  std::vector<Transfer> begun;
  std::vector<Transfer> ended;
  std::vector<double> releases;
  for (const Transfer& transfer : transfers) {
    if (transfer.before == level) begun.push_back(transfer);
    if (transfer.gap_changes == 0) continue;
    ended.push_back(transfer);
    releases.push_back(transfer.release);
  }
  const double release = median_of(releases);
  if (begun.size() < 2 || release <= 4 * microsecond || release >= 60 * microsecond) return;
  const double behaved = std::min({
      share_of(transfers, [&](const Transfer& t) { return t.after != level; }),
      share_of(ended, [](const Transfer& t) { return t.gap_changes == 1; }),
      share_near_median(releases, 0.15 * release + 0.2 * pair.clock.period + 2e3),
  });
  if (behaved < 0.8) return;
  double confidence = 0.9 * behaved;
  // Also if the word seems to be repeated: a word of BiSS C at rest may look like this.
  if (pulses > longest) confidence = std::min(confidence, 0.75);
  if (!biss.repeats) {
    if (pulses % 8 == 0) confidence = std::min(confidence, 0.55);
    // Without a 0 in the first bit the encoder could be one of BiSS C.
    const double zeros = share_of(begun, [](const Transfer& t) { return t.starts; });
    if (zeros < 0.05 && biss.guess.confidence > 0.2)
      confidence = std::min(confidence, pulses > longest ? 0.3 : 0.6);
  }
  if (biss.checked) confidence *= 0.3;
  guesses.push_back(
      {Protocol::ssi, confidence,
       fmt::format("bursts of {} clocks, data from the first one on, then {} for {:.1f} us", pulses,
                   level ? "low" : "high", release / microsecond)});
}

// ---- SPI, and a clock alone

// A clock in bytes and data that keeps to it.
void try_spi(const Pair& pair, const std::vector<Pair>& pairs, const BissTrial& biss,
             Guesses& guesses) {
  const std::vector<Transfer>& transfers = pair.transfers;
  const double bytes = share_of(transfers, [](const Transfer& t) { return t.pulses % 8 == 0; });
  if (transfers.size() < 2 || bytes < 0.85 || pair.coherence < 0.75 || pair.changes < 0.3) return;
  const bool selected = std::any_of(
      pairs.begin(), pairs.end(), [&](const Pair& each) { return &each != &pair && each.selects; });
  double confidence = selected ? 0.93 : 0.8;
  // Sensors on SPI have checksums too; a select line shows that it is SPI.
  if (biss.checked && !selected) confidence *= 0.4;
  guesses.push_back({Protocol::spi, confidence * bytes,
                     fmt::format("bursts of {} clocks, idle {}, data in step with them{}",
                                 pair.clock.usual_pulses, pair.clock.idle_high ? "high" : "low",
                                 selected ? ", framed by a select line" : "")});
}

void try_alone(const ClockShape& clock, const std::vector<Pair>& pairs, Guesses& guesses) {
  if (clock.regular < 0.75) return;
  double answers = 0;
  for (const Pair& pair : pairs) {
    if (pair.selects) continue;
    answers =
        std::max(answers, share_of(pair.transfers, [](const Transfer& t) { return t.moves; }));
  }
  if (answers >= 0.1) return;
  const double rate = 1e9 / clock.period;
  guesses.push_back(
      {Protocol::clock_alone, answers < 0.02 ? 0.93 : 0.6,
       clock.pauses
           ? fmt::format("{} bursts of a clock of {:.0f} kHz without an answer",
                         clock.bursts.size(), rate)
           : fmt::format("a clock of {:.0f} kHz without a pause and without an answer", rate)});
}

// ---- EnDat 2.1 and 2.2: mode commands of the master, then words with a CRC of 5 bits

// Over F1, F2 and the position, or over additional information. EnDat sends it inverted, but not all
// encoders do.
bool endat_crc_fits(BitView word, unsigned count, bool plain) {
  const CrcSpec spec{.polynomial = 0x2B, .start = 0x1F, .width_bits = 5, .inverted = !plain};
  if (count + 5 > word.size_bits()) return false;
  return CrcBitwise(spec)(word.word(0, count), count) == word.word(count, 5);
}

// The most bursts that begin with a mode command. The master changes its bits at one edge of the
// clock or the other, without a delay.
double endat_mode_share(const Pair& pair, bool inverted) {
  constexpr std::array<unsigned, 14> modes{0x07, 0x0E, 0x1C, 0x23, 0x2A, 0x15, 0x31,
                                           0x38, 0x09, 0x1B, 0x24, 0x2D, 0x36, 0x12};
  double best = 0;
  for (const double phase : {-0.05, 0.2, 0.45}) {
    const std::vector<Bits> words = words_at(pair, phase, inverted);
    for (const std::size_t from : {1U, 2U, 3U}) {
      best =
          std::max(best, share_of(words, [&](const Bits& bits) {
                     return bits.size_bits() >= from + 6 &&
                            std::count(modes.begin(), modes.end(), bits.view().word(from, 6)) != 0;
                   }));
    }
  }
  return best;
}

// How well the transfers agree with one reading of EnDat.
struct EndatFit {
  double bits = 0;
  unsigned position_bits = 0;
  std::size_t good = 0;
};

// F1, F2 and position of `count` bits, then the CRC. Only words that differ up to there count. The
// clocks end with the CRC, or with the CRC of additional information: START, 24 bits, CRC.
EndatFit fit_of_count(const std::vector<BitView>& words, std::size_t length_bits, unsigned count,
                      bool plain) {
  std::set<std::uint64_t> different;
  std::size_t good = 0;
  for (const BitView word : words) {
    if (!endat_crc_fits(word, count, plain)) continue;
    ++good;
    different.insert(word.word(0, count));
  }
  if (share(good, words.size()) < 0.7) return {};
  const std::size_t rest = length_bits - count - 5;
  const bool all_used = rest % 30 <= 1 && rest <= 61;
  double bits = 5 * static_cast<double>(different.size()) - (all_used ? 2.5 : 5.5);
  for (std::size_t end = count + 5; all_used && end + 30 <= length_bits; end += 30) {
    const double fit = share_of(
        words, [&](BitView word) { return endat_crc_fits(word.from(end + 1), 24, plain); });
    bits += fit >= 0.7 ? 5 : -5;
  }
  return {bits, count, good};
}

EndatFit fit_endat(const Pair& pair, bool inverted, double phase) {
  // The words that the encoder sends after its START, the first 1 after the bits of the master.
  const std::vector<Bits> all = words_at(pair, phase + 0.5, inverted);
  std::vector<BitView> words;
  std::size_t length_bits = 0;
  for (const Bits& bits : all) {
    std::size_t start = 9;
    while (start < bits.size_bits() && !bits.view()[start]) ++start;
    if (start + 2 > bits.size_bits()) continue;
    words.push_back(bits.view().from(start + 1));
    length_bits = std::max(length_bits, words.back().size_bits());
  }
  EndatFit best;
  if (words.size() < 2) return best;
  for (unsigned count = 9; count <= 52 && count + 5 <= length_bits; ++count) {
    for (const bool plain : {false, true}) {
      const EndatFit fit = fit_of_count(words, length_bits, count, plain);
      if (fit.bits > best.bits) best = fit;
    }
  }
  return best;
}

// Data rests at the opposite of the clock's level, and returns to it a fixed time after the last
// clock: the recovery time of 1.25 us to 3.75 us, or of 10 us to 30 us.
bool has_recovery(const Pair& pair) {
  std::vector<double> times;
  for (const Transfer& transfer : pair.transfers) {
    if (transfer.gap_changes != 0) times.push_back(transfer.recovery);
  }
  const double usual = median_of(times);
  const double resting =
      share_of(pair.transfers, [&](const Transfer& t) { return t.before != pair.clock.idle_high; });
  return usual > 1.0 * microsecond && usual < 35 * microsecond && resting >= 0.9 &&
         share(times.size(), pair.transfers.size()) >= 0.8 &&
         share_near_median(times, 0.15 * usual + 0.25 * pair.clock.period) > 0.85;
}

void try_endat(const Pair& pair, Guesses& guesses) {
  if (pair.clock.usual_pulses < 24 || pair.transfers.size() < 2) return;
  const double recovery_bits = has_recovery(pair) ? 5 : 0;
  ProtocolGuess guess{Protocol::endat22, 0, ""};
  for (const bool inverted : {false, true}) {
    const double modes = endat_mode_share(pair, inverted);
    if (modes < 0.8) continue;
    EndatFit best;
    for (const double phase : {pair.phase, 0.0, 0.25, 0.5, -0.25}) {
      const EndatFit fit = fit_endat(pair, inverted, phase);
      if (fit.bits > best.bits) best = fit;
    }
    const double bits = best.bits + recovery_bits;
    const double confidence = bits >= 14 ? 0.97 : bits >= 7 ? 0.85 : bits > 2 ? 0.6 : 0.1;
    if (confidence <= guess.confidence) continue;
    guess.confidence = confidence * modes;
    guess.why = fmt::format(
        "{:.0f} % of the bursts begin with a mode command, and the CRC x^5+x^3+x+1 fits {} words "
        "after {} bits",
        100 * modes, best.good, best.position_bits);
  }
  guesses.push_back(guess);
}

}  // namespace

void try_clocked(const Scene& scene, const BissTrial& biss, Guesses& guesses) {
  for (const Trace& clock : scene.lines) {
    if (clock.clock.regular < clock_share) continue;
    std::vector<Pair> pairs;
    for (const Trace& data : scene.lines) {
      if (&data != &clock) pairs.push_back(read_pair(scene, clock, data));
    }
    try_alone(clock.clock, pairs, guesses);
    if (!clock.clock.pauses) continue;
    for (const Pair& pair : pairs) {
      if (pair.data.changes.size() < 4) continue;
      try_endat(pair, guesses);
      try_ssi(pair, biss, guesses);
      try_spi(pair, pairs, biss, guesses);
    }
  }
}

}  // namespace biss::identify
