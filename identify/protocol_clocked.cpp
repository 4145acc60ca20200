// Protocols with a clock in bursts: SSI, SPI, and a clock that nothing answers.
#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "identify/protocol_pair.hpp"

namespace biss::identify {

namespace {

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

// What speaks for SSI.
struct SsiSigns {
  // Least share of the transfers that behave as SSI does.
  double share = 0;
  // Share of the transfers whose first bit is a 0.
  double first_bit = 0;
  // From the last clock to the data's return, in picoseconds.
  double release = 0;
};

// Data rests at one level, then a bit with each return of the clock to idle, then the other level
// for a fixed time. Of several words in a row only the first one begins at rest.
SsiSigns ssi_signs(const Pair& pair, bool level) {
  std::vector<Transfer> begun;
  std::vector<Transfer> ended;
  std::vector<double> releases;
  for (const Transfer& transfer : pair.transfers) {
    if (transfer.before == level) begun.push_back(transfer);
    if (transfer.gap_changes != 0) ended.push_back(transfer);
    if (transfer.release) releases.push_back(*transfer.release);
  }
  SsiSigns signs;
  if (begun.size() < 2 || releases.empty()) return signs;
  signs.release = median_of(releases);
  constexpr double nanosecond = 1e3;
  const double tolerance = 0.15 * signs.release + 0.2 * pair.period() + 2 * nanosecond;
  signs.share = std::min({
      share_of(pair.transfers, [&](const Transfer& t) { return t.after != level; }),
      share_of(ended, [](const Transfer& t) { return t.gap_changes == 1; }),
      share_of(pair.transfers, [](const Transfer& t) { return !t.prepared; }),
      share_of(begun, [](const Transfer& t) { return !t.first_change || *t.first_change > -0.15; }),
      share_near_median(releases, tolerance),
  });
  signs.first_bit =
      share_of(begun, [](const Transfer& t) { return t.first_change && *t.first_change < 0.85; });
  return signs;
}

ProtocolGuess try_ssi(const Pair& pair, const BissTrial& biss) {
  ProtocolGuess guess = guess_of(Protocol::ssi, pair, 0, "");
  const auto& transfers = pair.transfers;
  const std::size_t pulses = usual_pulses(pair.shape->bursts);
  constexpr std::size_t shortest = 9;
  constexpr std::size_t longest = 40;
  if (pulses < shortest || pulses > 8 * longest || pair.coherence < 0.75) return guess;
  const double whole =
      share_of(transfers, [&](const Transfer& t) { return t.pulses % pulses == 0; });
  if (whole < 0.8) return guess;
  // The probe may show either line inverted: data rests at the level it has before the longest gaps.
  const bool same =
      3 * std::count_if(transfers.begin(), transfers.end(),
                        [&](const Transfer& t) { return t.before == pair.shape->idle_high; }) >=
      static_cast<std::ptrdiff_t>(transfers.size());
  const bool level = pair.shape->idle_high == same;
  const SsiSigns signs = ssi_signs(pair, level);
  constexpr double microsecond = 1e6;
  const bool monoflop = signs.release > 4 * microsecond && signs.release < 60 * microsecond &&
                        signs.release > 0.8 * pair.period();
  if (!monoflop || signs.share < 0.8) return guess;
  guess.confidence = 0.9 * signs.share;
  const std::size_t word = repeated_word(transfers, pulses);
  if (word == 0) {
    if (pulses > longest) guess.confidence = std::min(guess.confidence, 0.75);
    if (pulses % 8 == 0) guess.confidence = std::min(guess.confidence, 0.55);
    // Without a 0 in the first bit the encoder could be one of BiSS C.
    const bool doubtful = signs.first_bit < 0.05 && biss.guess.confidence > 0.2;
    if (doubtful) guess.confidence = std::min(guess.confidence, pulses > longest ? 0.3 : 0.6);
  }
  if (biss.evidence == BissEvidence::checksum) guess.confidence *= 0.3;
  guess.why = fmt::format("bursts of {} clocks, data from the first one on, then {} for {:.1f} us",
                          pulses, level ? "low" : "high", signs.release / microsecond);
  return guess;
}

// A line that is held from before each burst to after it.
bool is_select(const Trace& line, const ClockShape& shape, const Trace& clock) {
  if (line.changes.size() < 4 || line.changes.size() > 2 * shape.bursts.size() + 2) return false;
  std::size_t low = 0;
  std::size_t high = 0;
  for (const Burst& burst : shape.bursts) {
    const std::size_t at = line.after(clock.changes[burst.first]);
    if (line.after(clock.changes[burst.last]) != at) continue;
    ++(line.level_before(at) ? high : low);
  }
  return 10 * std::max(low, high) >= 9 * shape.bursts.size();
}

// A clock in bytes and data that keeps to it.
ProtocolGuess try_spi(const Pair& pair, std::span<const Pair> pairs, const BissTrial& biss) {
  ProtocolGuess guess = guess_of(Protocol::spi, pair, 0, "");
  const auto& transfers = pair.transfers;
  const double bytes = share_of(transfers, [](const Transfer& t) { return t.pulses % 8 == 0; });
  const bool in_step = pair.coherence >= 0.75 && pair.changes >= 0.3;
  if (transfers.size() < 2 || bytes < 0.85 || !in_step) return guess;
  bool selected = false;
  bool second = false;
  for (const Pair& other : pairs) {
    if (other.line == pair.line) continue;
    const bool select = is_select(*other.line, *pair.shape, *pair.clock);
    selected = selected || select;
    second = second || (!select && other.coherence > 0.75 && other.changes > 0.3);
  }
  const bool idle_low = !pair.shape->idle_high;
  const double prepared = share_of(transfers, [](const Transfer& t) { return t.prepared; });
  double confidence = idle_low || prepared > 0.1 ? 0.8 : 0.7;
  if (second) confidence = 0.85;
  if (selected) confidence = 0.93;
  // Sensors on SPI have checksums too; a select line says which it is.
  const bool may_be_biss = biss.of_catalogue || !selected;
  if (biss.evidence == BissEvidence::checksum && may_be_biss) confidence *= 0.4;
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
      guesses.push_back(try_spi(pair, pairs, biss));
    }
  }
  return guesses;
}

}  // namespace biss::identify
