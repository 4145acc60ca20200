// BiSS Safety's two words together: how often both are accepted and the position is wrong all the
// same. A model of a channel, not a certificate; what it assumes stands in docs/safety-analysis.md.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/frame/format.hpp"
#include "lab/residual.hpp"

namespace biss::lab {

/// What the receiver checks beside the two checksums. Where the documents are silent: a default.
struct PairChecks {
  /// Singleturn bits that are compared, ACC_MIN of the encoder's type; 0: as many as both have.
  unsigned compare_bits = 0;
  /// By how much the compared values may differ, modulo their range: 0 or 1 (Safety Concept A5).
  unsigned tolerance_lsb = 1;
  /// Turns are compared where both words have some.
  bool compare_turns = true;
  /// The counter must be the expected one.
  bool counter = true;
  /// nE must say "no error" in both words.
  bool flags = true;
};

enum class PairError : std::uint8_t {
  no_pair,             ///< fewer than two channels, or no position in one of the first two
  nothing_to_compare,  ///< the positions have no bit in common, or one is in Gray code
  tolerance,           ///< more than 1, or than 0 where a single bit is compared
  too_many_checks,     ///< the two checksums have more than 24 bits together: takes too long
};

/// Error patterns over both words that every check accepts, by number of wrong bits: how many,
/// averaged over all positions. Exact up to the rounding of a long double.
struct PairWeights {
  unsigned bits = 0;           ///< of both words
  unsigned compared_bits = 0;  ///< turns included
  /// Any bit of either word is wrong.
  Undetected accepted;
  /// The control word's position is wrong in any bit. Below the compared bits nothing but the
  /// control word's own checksum looks at it.
  Undetected wrong;
  /// It is wrong by more than the comparison's tolerance: only with undetected errors in both.
  Undetected beyond_tolerance;
};

/// Why a format's first two channels cannot be counted; nothing when they can.
std::optional<PairError> pair_problem(const FrameFormat& format, const PairChecks& checks = {});

/// The first channel is the control word, the second one the safety word.
/// \pre pair_problem() has nothing to say
PairWeights pair_weights(const FrameFormat& format, const PairChecks& checks = {});

/// What PairError means, for people.
const char* text_of(PairError error);

}  // namespace biss::lab
