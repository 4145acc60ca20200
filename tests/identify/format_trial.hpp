// Random frame formats on a simulated line, and whether find_format() finds them.
#pragma once

#include <cstdint>
#include <string>

#include "biss/frame/format.hpp"
#include "identify/format.hpp"
#include "sim/line_setup.hpp"

namespace biss::trial {

/// A capture of an encoder with a random legal format.
struct FormatTrial {
  std::string text;
  sim::LineSetup setup;
  unsigned cycles = 0;
  /// The share of cycles with a fault.
  double damage = 0;
};

/// The trial of that number: the same on every machine.
FormatTrial random_trial(std::uint64_t number);
/// A capture of this format, otherwise as random_trial().
FormatTrial trial_of(const FrameFormat& format, sim::MotionKind motion, unsigned cycles,
                     std::uint64_t number);

struct TrialResult {
  identify::FormatFinding finding;
  /// How the first candidate differs from the truth on these frames; empty if the checksums have
  /// the same verdict on every frame, and the bits that moved have the same meaning.
  std::string mistake;
  /// The coding of the position differs: Gray for binary, or the other way round.
  bool other_coding = false;
  bool sure = false;
  /// Bits of the first position that moved in the frames.
  unsigned moved = 0;
};

TrialResult run(const FormatTrial& trial);

}  // namespace biss::trial
