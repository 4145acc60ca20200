// Protocols with a clock in bursts: SSI, EnDat 2.2, SPI, and a clock that nothing answers.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>

#include "identify/protocol_trials.hpp"

namespace biss::identify {

namespace {

constexpr std::size_t bursts_used = 400;
constexpr std::size_t pulses_used = 512;
// Of a period, pulses of data below this are no bits.
constexpr double glitch_share = 0.35;

// The data of one burst of the clock.
struct Transfer {
  Picoseconds begin{};
  Picoseconds end{};
  std::size_t pulses = 0;
  // The level of the data when the clock starts, and a period after its last edge.
  bool before = false;
  bool after = false;
  // Data changes shortly before the clock starts.
  bool prepared = false;
  // First change of the data after `begin`, in periods from the clock's first return to idle.
  std::optional<double> first_change;
  // Changes of the data between this burst and the next, and when the first one comes.
  std::size_t gap_changes = 0;
  std::optional<double> release;
  // Level after each return of the clock to idle.
  std::vector<bool> bits;
};

// A clock and a line of data.
struct Pair {
  const Trace* clock = nullptr;
  const ClockShape* shape = nullptr;
  const Trace* line = nullptr;
  // The line without pulses that are too short for bits.
  Trace data;
  // Changes of data per burst, and how far they keep to one phase of the clock: 0 to 1.
  double changes = 0;
  double coherence = 0;
  // The usual phase, in periods after the clock's return to idle: -0.5 to 0.5.
  double phase = 0;
  std::vector<Transfer> transfers;

  double period() const { return shape->period; }
};

Picoseconds later(Picoseconds time, double by) {
  return decode::shifted(time, Picoseconds{static_cast<std::int64_t>(by)});
}

// The time of return to idle of pulse `k`.
Picoseconds return_of(const Pair& pair, const Burst& burst, std::size_t k) {
  return pair.clock->changes[burst.first + 2 * k + 1];
}

void measure_phase(Pair& pair) {
  double cosine = 0;
  double sine = 0;
  double count = 0;
  for (const Burst& burst : pair.shape->bursts) {
    const Picoseconds begin = pair.clock->changes[burst.first];
    const Picoseconds stop = later(pair.clock->changes[burst.last], 0.9 * pair.period());
    std::size_t k = 0;
    for (std::size_t i = pair.data.after(begin); i < pair.data.changes.size(); ++i) {
      const Picoseconds time = pair.data.changes[i];
      if (time > stop) break;
      while (k + 1 < burst.pulses() && return_of(pair, burst, k + 1) <= time) ++k;
      const Picoseconds edge = return_of(pair, burst, k);
      const double off = edge <= time ? length(edge, time) : -length(time, edge);
      const double angle = 2 * std::numbers::pi * off / pair.period();
      cosine += std::cos(angle);
      sine += std::sin(angle);
      ++count;
    }
  }
  if (count == 0) return;
  pair.coherence = std::hypot(cosine, sine) / count;
  pair.phase = std::atan2(sine, cosine) / (2 * std::numbers::pi);
  pair.changes = count / static_cast<double>(pair.shape->bursts.size());
}

Transfer read_transfer(const Pair& pair, std::size_t index, Picoseconds end) {
  const std::vector<Burst>& bursts = pair.shape->bursts;
  const Burst& burst = bursts[index];
  const double period = pair.period();
  Transfer transfer;
  transfer.begin = pair.clock->changes[burst.first];
  transfer.end = pair.clock->changes[burst.last];
  transfer.pulses = burst.pulses();
  const Picoseconds just_before = later(transfer.begin, -0.1 * period);
  transfer.before = pair.data.level_at(just_before);
  const std::size_t first = pair.data.after(just_before);
  if (first > 0) {
    const double ago = length(pair.data.changes[first - 1], std::max(just_before, pair.data.changes[first - 1]));
    const bool own = index == 0 || pair.data.changes[first - 1] >
                                       later(pair.clock->changes[bursts[index - 1].last], 2 * period);
    transfer.prepared = own && ago < 3 * period;
  }
  const std::size_t inside = pair.data.after(transfer.begin);
  if (inside < pair.data.changes.size() && pair.data.changes[inside] < later(transfer.end, period)) {
    const Picoseconds edge = return_of(pair, burst, 0);
    const Picoseconds time = pair.data.changes[inside];
    transfer.first_change = (edge <= time ? length(edge, time) : -length(time, edge)) / period;
  }
  const double delay = (pair.phase < -0.25 ? pair.phase + 1 : std::max(pair.phase, 0.0)) * period;
  const Picoseconds settled = later(transfer.end, delay + 0.3 * period);
  const Picoseconds next = index + 1 < bursts.size()
                               ? later(pair.clock->changes[bursts[index + 1].first], -0.1 * period)
                               : end;
  transfer.after = pair.data.level_at(std::min(settled, next));
  for (std::size_t i = pair.data.after(settled); i < pair.data.changes.size(); ++i) {
    const Picoseconds time = pair.data.changes[i];
    if (time >= next) break;
    if (!transfer.release && time > transfer.end) transfer.release = length(transfer.end, time);
    ++transfer.gap_changes;
  }
  for (std::size_t k = 0; k < std::min(transfer.pulses, pulses_used); ++k) {
    transfer.bits.push_back(
        pair.data.level_at(later(return_of(pair, burst, k), (pair.phase + 0.5) * period)));
  }
  return transfer;
}

Pair read_pair(const Scene& scene, std::size_t clock, std::size_t data) {
  Pair pair;
  pair.clock = &scene.traces[clock];
  pair.shape = &scene.clocks[clock];
  pair.line = &scene.traces[data];
  pair.data = without_pulses(*pair.line, glitch_share * pair.period());
  measure_phase(pair);
  const std::size_t count = std::min(pair.shape->bursts.size(), bursts_used);
  for (std::size_t i = 0; i < count; ++i) {
    pair.transfers.push_back(read_transfer(pair, i, scene.end));
  }
  return pair;
}

template <class Property>
double share_of(const std::vector<Transfer>& transfers, Property property) {
  if (transfers.empty()) return 0;
  const auto count = std::count_if(transfers.begin(), transfers.end(), property);
  return static_cast<double>(count) / static_cast<double>(transfers.size());
}

ProtocolGuess guess_of(Protocol protocol, const Pair& pair, double confidence, std::string why) {
  return {protocol, confidence, std::move(why), pair.clock->line, pair.data.line, true};
}

// The clocks of one word, where every burst gives one word several times; 0 where none does.
std::size_t repeated_word(const std::vector<Transfer>& transfers, std::size_t pulses) {
  for (const std::size_t words : {2U, 3U, 4U, 5U, 6U, 7U, 8U}) {
    const std::size_t length_bits = pulses / words;
    if (pulses % words != 0 || length_bits < 10) continue;
    const double same = share_of(transfers, [&](const Transfer& t) {
      if (t.pulses != pulses || t.bits.size() != pulses) return false;
      std::size_t changes = 0;
      for (std::size_t k = 0; k + length_bits < pulses; ++k) {
        if (t.bits[k] != t.bits[k + length_bits]) return false;
        changes += t.bits[k] != t.bits[k + 1] ? 1U : 0U;
      }
      return changes >= 3;
    });
    if (same > 0.8) return length_bits;
  }
  return 0;
}

// SSI: data rests at 1, then a bit with each return of the clock to idle, then 0 for a fixed time.
ProtocolGuess try_ssi(const Pair& pair, const BissTrial& biss) {
  const auto& transfers = pair.transfers;
  const std::size_t pulses = usual_pulses(pair.shape->bursts);
  // Multiple transmission: the next burst comes before the encoder is idle again.
  const bool rest = pair.shape->idle_high;
  const double rests = share_of(transfers, [&](const Transfer& t) { return t.before == rest; });
  const double repeats = share_of(
      transfers, [&](const Transfer& t) { return t.before == rest || t.gap_changes == 0; });
  // A probe may show either line inverted: what counts is that the data rests at one level.
  bool level = rest;
  if (rests < 0.3) level = !rest;
  const auto resting = [&](const Transfer& t) { return t.before == level; };
  std::vector<Transfer> begun;
  std::vector<Transfer> ended;
  for (const Transfer& transfer : transfers) {
    if (resting(transfer)) begun.push_back(transfer);
    if (transfer.gap_changes != 0) ended.push_back(transfer);
  }
  const double whole = share_of(transfers, [&](const Transfer& t) {
    return t.pulses == pulses || (t.pulses > pulses && t.pulses % pulses == 0);
  });
  ProtocolGuess guess = guess_of(Protocol::ssi, pair, 0, "");
  const std::size_t shortest = 9;
  const std::size_t longest = 40;
  const bool ring = pulses > longest && pulses <= 8 * longest;
  if (pulses < shortest || pulses > 8 * longest || begun.size() < 2 || ended.empty()) return guess;
  if (whole < 0.8 || pair.coherence < 0.75 || repeats < 0.7 * rests) return guess;
  std::vector<double> releases;
  for (const Transfer& transfer : ended) {
    if (transfer.release) releases.push_back(*transfer.release);
  }
  const double release = median_of(releases);
  const double steady = share_near_median(releases, 0.15 * release + 2 * (0.1 * pair.period() + static_cast<double>(1000)));
  const double low_after = share_of(transfers, [&](const Transfer& t) { return t.after != level; });
  const double one_release =
      share_of(ended, [](const Transfer& t) { return t.gap_changes == 1; });
  const double unprepared = share_of(transfers, [](const Transfer& t) { return !t.prepared; });
  const double late = share_of(begun, [](const Transfer& t) {
    return !t.first_change || *t.first_change > -0.15;
  });
  const double first_bit = share_of(begun, [](const Transfer& t) {
    return t.first_change && *t.first_change < 0.95;
  });
  constexpr double microsecond = 1e6;
  const bool monoflop = release > 4 * microsecond && release < 60 * microsecond &&
                        release > 0.8 * pair.period();
  const double structure = std::min({low_after, one_release, unprepared, late, steady});
  if (!monoflop || structure < 0.8) return guess;
  guess.confidence = 0.9 * structure;
  const std::size_t word = repeated_word(transfers, pulses);
  if (ring && word == 0) guess.confidence = std::min(guess.confidence, 0.75);
  const bool bytes = pulses % 8 == 0 && word == 0;
  if (bytes) guess.confidence = std::min(guess.confidence, 0.55);
  if (biss.evidence == BissEvidence::checksum) guess.confidence *= 0.3;
  // Without a 0 in the first bit the encoder could be one of BiSS C.
  if (word == 0 && first_bit < 0.05 && biss.guess.confidence > 0.2) {
    guess.confidence = std::min(guess.confidence, 0.6);
  }
  guess.why = fmt::format(
      "bursts of {} clocks, data from the first one on, then {} for {:.1f} us", pulses,
      level ? "low" : "high", release / microsecond);
  return guess;
}

// A line that is held from before each burst to after it.
bool is_select(const Trace& line, const ClockShape& shape, const Trace& clock) {
  if (line.changes.size() < 4 || line.changes.size() > 2 * shape.bursts.size() + 2) return false;
  std::size_t framed = 0;
  bool rest = line.first_high;
  for (const Burst& burst : shape.bursts) {
    const Picoseconds begin = clock.changes[burst.first];
    const Picoseconds end = clock.changes[burst.last];
    const std::size_t at = line.after(begin);
    if (line.after(end) == at && line.level_before(at) != rest) ++framed;
  }
  if (10 * framed < 9 * shape.bursts.size()) {
    rest = !rest;
    framed = shape.bursts.size() - framed;
    return false;
  }
  return true;
}

// The CRC of EnDat: x^5 + x^3 + x + 1 over F1, F2 and the position, start 0x1F, inverted.
unsigned endat_crc(const std::vector<bool>& bits, std::size_t from, std::size_t count, bool inverted) {
  unsigned crc = 0x1F;
  for (std::size_t i = from; i < from + count; ++i) {
    const bool out = (crc >> 4U & 1U) != 0;
    crc = (crc << 1U) & 0x1FU;
    if (out != (bits[i] != inverted)) crc ^= 0x0BU;
  }
  return ~crc & 0x1FU;
}

bool endat_crc_fits(const std::vector<bool>& bits, std::size_t from, std::size_t count, bool inverted) {
  if (from + count + 5 > bits.size()) return false;
  const unsigned expected = endat_crc(bits, from, count, inverted);
  unsigned received = 0;
  for (std::size_t i = from + count; i < from + count + 5; ++i) {
    received = received << 1U | (bits[i] != inverted ? 1U : 0U);
  }
  return received == expected;
}

// The mode commands of EnDat 2.1 and 2.2, first bit first.
constexpr std::array<unsigned, 14> endat_modes{0x07, 0x0E, 0x1C, 0x23, 0x2A, 0x15, 0x31,
                                               0x38, 0x09, 0x1B, 0x24, 0x2D, 0x36, 0x12};

bool is_endat_mode(const std::vector<bool>& bits, std::size_t from, bool inverted) {
  if (from + 6 > bits.size()) return false;
  unsigned mode = 0;
  for (std::size_t i = from; i < from + 6; ++i) mode = mode << 1U | (bits[i] != inverted ? 1U : 0U);
  return std::find(endat_modes.begin(), endat_modes.end(), mode) != endat_modes.end();
}

// How well the transfers agree with one reading of EnDat.
struct EndatFit {
  double bits = 0;
  std::size_t position_bits = 0;
  std::size_t good = 0;
};

// The master's bits at the clock's first edges, without a delay: `at_return` says which edge.
std::vector<std::vector<bool>> master_bits(const Pair& pair, double phase) {
  std::vector<std::vector<bool>> all;
  for (std::size_t i = 0; i < pair.transfers.size(); ++i) {
    std::vector<bool> bits;
    const Burst& burst = pair.shape->bursts[i];
    for (std::size_t k = 0; k < std::min<std::size_t>(burst.pulses(), 10); ++k) {
      bits.push_back(pair.data.level_at(later(return_of(pair, burst, k), phase * pair.period())));
    }
    all.push_back(std::move(bits));
  }
  return all;
}

// The bits that the encoder sends, sampled half a period after `phase`.
std::vector<std::vector<bool>> encoder_bits(const Pair& pair, double phase) {
  std::vector<std::vector<bool>> all;
  for (std::size_t i = 0; i < pair.transfers.size(); ++i) {
    std::vector<bool> bits;
    const Burst& burst = pair.shape->bursts[i];
    for (std::size_t k = 0; k < std::min(burst.pulses(), pulses_used); ++k) {
      bits.push_back(pair.data.level_at(later(return_of(pair, burst, k), (phase + 0.5) * pair.period())));
    }
    all.push_back(std::move(bits));
  }
  return all;
}

double endat_mode_share(const Pair& pair, bool inverted) {
  double best = 0;
  for (const double phase : {-0.05, 0.2, 0.45}) {
    const auto all = master_bits(pair, phase);
    for (const std::size_t from : {1U, 2U, 3U}) {
      const auto legal = std::count_if(all.begin(), all.end(), [&](const std::vector<bool>& bits) {
        return is_endat_mode(bits, from, inverted);
      });
      best = std::max(best, static_cast<double>(legal) / static_cast<double>(all.size()));
    }
  }
  return best;
}

// Frames that differ and have the CRC at one place: F1, F2, position, CRC from the first 1 after the
// master's bits on.
EndatFit fit_endat(const Pair& pair, bool inverted, double phase) {
  std::vector<std::vector<bool>> words;
  for (std::vector<bool>& bits : encoder_bits(pair, phase)) {
    std::size_t start = 9;
    while (start < bits.size() && bits[start] == inverted) ++start;
    if (start + 1 >= bits.size()) continue;
    bits.erase(bits.begin(), bits.begin() + static_cast<std::ptrdiff_t>(start + 1));
    words.push_back(std::move(bits));
  }
  EndatFit best;
  if (words.size() < 2) return best;
  std::size_t length_bits = 0;
  for (const auto& word : words) length_bits = std::max(length_bits, word.size());
  for (std::size_t count = 9; count <= 52 && count + 5 <= length_bits; ++count) {
    // Only words that differ up to the CRC count.
    std::set<std::vector<bool>> good;
    std::size_t fitting = 0;
    for (const auto& word : words) {
      if (!endat_crc_fits(word, 0, count, inverted)) continue;
      ++fitting;
      good.insert({word.begin(), word.begin() + static_cast<std::ptrdiff_t>(count + 5)});
    }
    if (10 * fitting < 7 * words.size()) continue;
    // The clocks end with the CRC, or with that of additional information.
    const std::size_t rest = length_bits - count - 5;
    const bool all_used = rest % 30 <= 1 && rest <= 61;
    double bits = 5 * static_cast<double>(good.size()) - (all_used ? 2.5 : 5.5);
    for (std::size_t more = 0; all_used && more < rest / 30; ++more) {
      const std::size_t from = count + 5 + 30 * more + 1;
      const auto fits = std::count_if(words.begin(), words.end(), [&](const auto& each) {
        return endat_crc_fits(each, from, 24, inverted);
      });
      bits += 10 * static_cast<std::size_t>(fits) >= 7 * words.size() ? 5 : -5;
    }
    if (bits > best.bits) best = {bits, count, fitting};
  }
  return best;
}

// Data rests at the level at which the clock does not, and returns there from the other one a fixed
// time after the last clock: the recovery time of 1.25 us to 3.75 us, or of 10 us to 30 us.
bool has_recovery(const Pair& pair) {
  const bool rest = !pair.shape->idle_high;
  std::vector<double> times;
  std::size_t resting = 0;
  for (std::size_t i = 1; i < pair.transfers.size(); ++i) {
    if (pair.transfers[i].before != rest) continue;
    ++resting;
    const Picoseconds next = later(pair.transfers[i].begin, -0.1 * pair.period());
    const std::size_t at = pair.data.after(next);
    const Picoseconds end = pair.transfers[i - 1].end;
    if (at != 0 && pair.data.changes[at - 1] > end) {
      times.push_back(length(end, pair.data.changes[at - 1]));
    }
  }
  constexpr double microsecond = 1e6;
  const double usual = median_of(times);
  const bool legal = usual > 1.0 * microsecond && usual < 35 * microsecond;
  const double steady = share_near_median(times, 0.15 * usual + 2 * pair.period() / 8);
  return 10 * resting >= 9 * (pair.transfers.size() - 1) && 10 * times.size() >= 9 * resting &&
         legal && steady > 0.85;
}

ProtocolGuess try_endat(const Pair& pair) {
  ProtocolGuess guess = guess_of(Protocol::endat22, pair, 0, "");
  if (usual_pulses(pair.shape->bursts) < 24 || pair.transfers.size() < 2) return guess;
  const double recovery_bits = has_recovery(pair) ? 5 : 0;
  for (const bool inverted : {false, true}) {
    const double modes = endat_mode_share(pair, inverted);
    if (modes < 0.8) continue;
    EndatFit best;
    for (const double phase : {pair.phase, 0.0, 0.25, 0.5, -0.25}) {
      const EndatFit fit = fit_endat(pair, inverted, phase);
      if (fit.bits > best.bits) best = fit;
    }
    if (best.bits > 0 || recovery_bits != 0) best.bits += recovery_bits;
    const double confidence = best.bits >= 14 ? 0.97 : best.bits >= 7 ? 0.85 : best.bits > 2 ? 0.6 : 0.1;
    if (confidence <= guess.confidence) continue;
    guess.confidence = confidence * modes;
    guess.why = fmt::format(
        "{:.0f} % of the bursts begin with a mode command, and the CRC x^5+x^3+x+1 fits {} words "
        "after {} bits",
        100 * modes, best.good, best.position_bits);
  }
  return guess;
}

// SPI: a clock in bytes and data that keeps to it.
ProtocolGuess try_spi(const Scene& scene, const Pair& pair, const BissTrial& biss) {
  ProtocolGuess guess = guess_of(Protocol::spi, pair, 0, "");
  const auto& transfers = pair.transfers;
  const double bytes = share_of(transfers, [](const Transfer& t) { return t.pulses % 8 == 0; });
  if (transfers.size() < 2 || bytes < 0.85 || pair.coherence < 0.75 || pair.changes < 0.3) return guess;
  bool selected = false;
  bool second = false;
  for (const Trace& line : scene.traces) {
    if (line.line == pair.clock->line || line.line == pair.data.line) continue;
    if (is_select(line, *pair.shape, *pair.clock)) {
      selected = true;
      continue;
    }
    const auto index = static_cast<std::size_t>(&line - scene.traces.data());
    const Pair other = read_pair(scene, static_cast<std::size_t>(pair.clock - scene.traces.data()), index);
    if (other.coherence > 0.75 && other.changes > 0.3) second = true;
  }
  const bool idle_low = !pair.shape->idle_high;
  const double prepared = share_of(transfers, [](const Transfer& t) { return t.prepared; });
  double confidence = 0.7;
  if (idle_low || prepared > 0.1) confidence = 0.8;
  if (second) confidence = 0.85;
  if (selected) confidence = 0.93;
  if (biss.evidence == BissEvidence::checksum) confidence *= 0.4;
  guess.confidence = confidence * bytes;
  guess.why = fmt::format("bursts of {} clocks, idle {}, data in step with them{}{}",
                          usual_pulses(pair.shape->bursts), idle_low ? "low" : "high",
                          second ? ", on a second line too" : "",
                          selected ? ", framed by a select line" : "");
  return guess;
}

ProtocolGuess try_alone(const Scene& scene, std::size_t clock, std::span<const Pair> pairs) {
  const ClockShape& shape = scene.clocks[clock];
  const wire::LineIndex line = scene.traces[clock].line;
  ProtocolGuess guess{Protocol::clock_alone, 0, "", line, line, true};
  if (shape.regular < 0.75) return guess;
  double answers = 0;
  for (const Pair& pair : pairs) {
    const Trace& data = *pair.line;
    if (is_select(data, shape, *pair.clock)) continue;
    // Pulses that are too short for this clock may be those of another one.
    const bool busy = 5 * data.changes.size() > pair.clock->changes.size();
    const double share = busy ? 1.0 : share_of(pair.transfers, [](const Transfer& t) {
      return t.first_change.has_value() || t.gap_changes != 0;
    });
    answers = std::max(answers, share);
    guess.data = data.line;
  }
  guess.confidence = answers < 0.02 ? 0.93 : answers < 0.1 ? 0.6 : 0;
  guess.why = shape.pauses ? fmt::format("{} bursts of a clock of {:.0f} kHz, nothing answers",
                                         shape.bursts.size(), 1e9 / shape.period)
                           : fmt::format("a clock of {:.0f} kHz without a pause, nothing answers",
                                         1e9 / shape.period);
  return guess;
}

}  // namespace

Guesses try_clocked(const Scene& scene, const BissTrial& biss) {
  Guesses guesses;
  for (std::size_t c = 0; c < scene.traces.size(); ++c) {
    if (scene.clocks[c].regular < clock_share) continue;
    std::vector<Pair> pairs;
    for (std::size_t d = 0; d < scene.traces.size(); ++d) {
      if (d != c) pairs.push_back(read_pair(scene, c, d));
    }
    guesses.push_back(try_alone(scene, c, pairs));
    if (!scene.clocks[c].pauses) continue;
    for (const Pair& pair : pairs) {
      if (pair.data.changes.size() < 4) continue;
      guesses.push_back(try_endat(pair));
      guesses.push_back(try_ssi(pair, biss));
      guesses.push_back(try_spi(scene, pair, biss));
    }
  }
  return guesses;
}

}  // namespace biss::identify
