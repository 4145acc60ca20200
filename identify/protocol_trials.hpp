// The trials of recognise_protocol(), each for one family of protocols.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/protocol.hpp"
#include "identify/protocol_trace.hpp"

namespace biss::identify {

/// What all trials look at.
struct Scene {
  /// All edges, for decode::Decoder.
  std::span<const wire::Edge> edges;
  /// The lines that change, busiest first.
  std::vector<Trace> traces;
  /// The same lines read as clocks.
  std::vector<ClockShape> clocks;
  Picoseconds sample_period{};
  Picoseconds end{};

  double sample() const { return static_cast<double>(sample_period.count); }
};

using Guesses = std::vector<ProtocolGuess>;

/// A line is a clock where this share of its changes is regular; BiSS C with faults has less.
inline constexpr double clock_share = 0.7;
inline constexpr double damaged_clock_share = 0.4;

/// What says that the words are those of BiSS C.
enum class BissEvidence : std::uint8_t { none, structure, checksum };

struct BissTrial {
  BissEvidence evidence = BissEvidence::none;
  /// The checksums of a type of the catalogue fit.
  bool of_catalogue = false;
  ProtocolGuess guess;
};

BissTrial try_biss(const Scene& scene);
/// SSI, EnDat, SPI, a clock alone.
Guesses try_clocked(const Scene& scene, const BissTrial& biss);
/// I2C and quadrature.
Guesses try_two_wire(const Scene& scene);
/// UART, encoders on UART words, HIPERFACE DSL, noise.
Guesses try_serial(const Scene& scene);

}  // namespace biss::identify
