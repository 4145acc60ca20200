#include "identify/protocol.hpp"

#include <algorithm>
#include <utility>

#include "identify/protocol_trials.hpp"

namespace biss::identify {

namespace {

constexpr double worth_a_line = 0.05;
// Another protocol than BiSS C is named from here on.
constexpr double clear = 0.5;

double confidence_in(const Guesses& guesses, Protocol protocol) {
  double most = 0;
  for (const ProtocolGuess& guess : guesses) {
    if (guess.protocol == protocol) most = std::max(most, guess.confidence);
  }
  return most;
}

// One guess a protocol, best first.
Guesses sorted(Guesses guesses) {
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
  Guesses kept;
  for (ProtocolGuess& guess : guesses) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const ProtocolGuess& other) {
      return other.protocol == guess.protocol;
    });
    if (!known && guess.confidence >= worth_a_line) kept.push_back(std::move(guess));
  }
  return kept;
}

}  // namespace

std::vector<ProtocolGuess> recognise_protocol(std::span<const wire::Edge> beginning,
                                              std::size_t lines, Picoseconds sample_period,
                                              Picoseconds end) {
  Scene scene{.edges = beginning,
              .traces = moving_lines(beginning, lines),
              .clocks = {},
              .sample_period = sample_period,
              .end = end};
  if (scene.traces.empty()) return {{Protocol::idle, 1, "no line changes", 0, 0, false}};
  for (const Trace& trace : scene.traces) {
    scene.clocks.push_back(clock_shape(trace, sample_period));
  }
  BissTrial biss = try_biss(scene);
  Guesses guesses = try_clocked(scene, biss);
  const auto take = [&](Guesses more) {
    std::move(more.begin(), more.end(), std::back_inserter(guesses));
  };
  take(try_two_wire(scene));
  take(try_serial(scene));
  // Inverted EnDat answers much as BiSS C does, and has a CRC.
  if (confidence_in(guesses, Protocol::endat22) > 0.9) biss.guess.confidence *= 0.3;
  // A frame of BiSS C that does not change may have the clocks of whole bytes, and a byte of I2C the
  // bits of a frame; a checksum decides.
  if (biss.evidence == BissEvidence::checksum) {
    for (ProtocolGuess& guess : guesses) {
      if (guess.protocol == Protocol::i2c) guess.confidence *= 0.3;
    }
  } else if (confidence_in(guesses, Protocol::i2c) > 0.9) {
    biss.guess.confidence *= 0.3;
  }
  // So sure only with a select line.
  if (!biss.of_catalogue && confidence_in(guesses, Protocol::spi) > 0.9) {
    biss.guess.confidence = std::min(biss.guess.confidence, 0.4);
  }
  const double neighbour =
      std::max(confidence_in(guesses, Protocol::endat22), confidence_in(guesses, Protocol::ssi));
  if (biss.evidence == BissEvidence::structure && neighbour > clear) {
    biss.guess.confidence = std::min(biss.guess.confidence, 0.4);
  }
  guesses.push_back(std::move(biss.guess));
  guesses.push_back({Protocol::unknown, clear, "no protocol is clear", scene.traces.front().line,
                     scene.traces.front().line, false});
  return sorted(std::move(guesses));
}

}  // namespace biss::identify
