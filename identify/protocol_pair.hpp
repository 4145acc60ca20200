// A clock and a line of data, burst by burst.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/protocol_trials.hpp"

namespace biss::identify {

/// Of each burst, this many pulses are read.
inline constexpr std::size_t pulses_used = 512;

/// The data of one burst of the clock.
struct Transfer {
  Picoseconds begin{};
  Picoseconds end{};
  std::size_t pulses = 0;
  /// The level of the data when the clock starts, and a period after its last edge.
  bool before = false;
  bool after = false;
  /// Data changes shortly before the clock starts.
  bool prepared = false;
  /// First change of the data after `begin`, in periods from the clock's first return to idle.
  std::optional<double> first_change;
  /// Changes of the data between this burst and the next, and when the first one comes.
  std::size_t gap_changes = 0;
  std::optional<double> release;
  /// Level after each return of the clock to idle.
  std::vector<bool> bits;
};

/// A clock and a line of data.
struct Pair {
  const Trace* clock = nullptr;
  const ClockShape* shape = nullptr;
  const Trace* line = nullptr;
  /// The line without pulses that are too short for bits.
  Trace data;
  /// Changes of data per burst, and how far they keep to one phase of the clock: 0 to 1.
  double changes = 0;
  double coherence = 0;
  /// The usual phase, in periods after the clock's return to idle: -0.5 to 0.5.
  double phase = 0;
  std::vector<Transfer> transfers;

  double period() const { return shape->period; }
};

/// The pair of the lines `clock` and `data` of the scene.
Pair read_pair(const Scene& scene, std::size_t clock, std::size_t data);

inline Picoseconds later(Picoseconds time, double by) {
  return decode::shifted(time, Picoseconds{static_cast<std::int64_t>(by)});
}

/// The time at which the clock returns to idle after pulse `k`.
inline Picoseconds return_of(const Pair& pair, const Burst& burst, std::size_t k) {
  return pair.clock->changes[burst.first + 2 * k + 1];
}

template <class Property>
double share_of(const std::vector<Transfer>& transfers, Property property) {
  if (transfers.empty()) return 0;
  const auto count = std::count_if(transfers.begin(), transfers.end(), property);
  return static_cast<double>(count) / static_cast<double>(transfers.size());
}

inline ProtocolGuess guess_of(Protocol protocol, const Pair& pair, double confidence,
                              std::string why) {
  return {protocol, confidence, std::move(why), pair.clock->line, pair.data.line, true};
}

/// EnDat 2.1 or 2.2.
ProtocolGuess try_endat(const Pair& pair);

}  // namespace biss::identify
