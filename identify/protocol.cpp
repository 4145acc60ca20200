#include "identify/protocol.hpp"

#include <algorithm>

#include "identify/protocol_lines.hpp"

namespace biss::identify {

namespace {

// Another protocol than BiSS C is named from here on.
constexpr double clear = 0.5;

double confidence_in(const Guesses& guesses, Protocol protocol) {
  double most = 0;
  for (const ProtocolGuess& guess : guesses) {
    if (guess.protocol == protocol) most = std::max(most, guess.confidence);
  }
  return most;
}

// Weighs BiSS C and the others against each other.
void weigh(BissTrial& biss, Guesses& guesses) {
  const double endat = confidence_in(guesses, Protocol::endat22);
  const double i2c = confidence_in(guesses, Protocol::i2c);
  double& confidence = biss.guess.confidence;
  // Inverted EnDat answers much as BiSS C does, and has a CRC.
  if (endat > 0.9) confidence *= 0.3;
  // A frame of BiSS C that does not change may have the clocks of whole bytes, and a byte of I2C the
  // bits of a frame; a checksum decides.
  if (biss.checked) {
    for (ProtocolGuess& guess : guesses) {
      if (guess.protocol == Protocol::i2c) guess.confidence *= 0.3;
    }
  } else if (i2c > 0.9) {
    confidence *= 0.3;
  }
  if (!biss.checked && std::max(endat, confidence_in(guesses, Protocol::ssi)) > clear)
    confidence = std::min(confidence, 0.4);
}

}  // namespace

std::vector<ProtocolGuess> recognise_protocol(std::span<const wire::Edge> beginning,
                                              std::size_t lines, Picoseconds sample_period,
                                              Picoseconds end) {
  const auto sample = static_cast<double>(sample_period.count);
  const Scene scene{beginning, moving_lines(beginning, lines, sample), sample, end};
  if (scene.lines.empty()) return {{Protocol::idle, 1, "no line changes"}};
  BissTrial biss = try_biss(scene);
  Guesses guesses;
  try_clocked(scene, biss, guesses);
  try_two_wire(scene, guesses);
  try_serial(scene, guesses);
  weigh(biss, guesses);
  guesses.push_back(biss.guess);
  guesses.push_back({Protocol::unknown, clear, "no protocol is clear"});
  std::stable_sort(guesses.begin(), guesses.end(),
                   [](const auto& a, const auto& b) { return a.confidence > b.confidence; });
  return guesses;
}

}  // namespace biss::identify
