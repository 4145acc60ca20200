// The two words of BiSS Safety together: how often both are accepted although the position is
// wrong. A model of a channel, not a certificate; docs/safety-experiments.md lists its assumptions.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/safety/rating.hpp"
#include "biss/safety/setup.hpp"
#include "lab/residual.hpp"

namespace biss::lab {

/// A bit of the control word and the bit of the safety word that must agree with it. Both are
/// counted from the last data bit of their word.
struct ComparedBit {
  std::uint8_t control_shift = 0;
  std::uint8_t safety_shift = 0;
};

/// The bits of both positions with the same meaning, most significant first: singleturn (or `pos`)
/// aligned at its first bit, turns at their last bit (fact sheet, 5.3). Turns and singleturn are
/// one number, so a carry between them is not a difference. Empty if nothing can be compared, and
/// for Gray code.
std::vector<ComparedBit> compared_bits(const ChannelFormat& control, const ChannelFormat& safety,
                                       const SafetyComparison& comparison = {});

/// For each set of wrong bits among `bits` compared bits: the share of positions for which it
/// passes. The true position is evenly distributed, and the two received values differ by at most
/// `tolerance`, modulo 2^bits. Sets that never pass are not listed. All shares are exact.
/// \pre bits is 1…64; tolerance is small and less than 2^(bits-1)
std::map<std::uint64_t, long double> passing_masks(unsigned bits, unsigned tolerance);

enum class PairError : std::uint8_t {
  no_pair,             ///< fewer than two channels, or no position in one of the first two
  nothing_to_compare,  ///< the positions have no bit in common, or one is in Gray code
  tolerance,           ///< more than 1, or more than 0 with a single compared bit
  too_many_checks,     ///< the two checksums have more than 24 bits together: takes too long
};

/// Error patterns over both words that every check accepts, by number of wrong bits: how many,
/// averaged over all positions. Exact up to the rounding of a long double.
struct PairWeights {
  unsigned bits = 0;           ///< of both words
  unsigned compared_bits = 0;  ///< turns included
  /// Any bit of either word is wrong.
  Undetected accepted;
  /// Any bit of the control word's position is wrong. Below the compared bits, only the control
  /// word's own checksum protects it.
  Undetected wrong;
  /// The position is wrong by more than the tolerance: only with undetected errors in both words.
  Undetected beyond_tolerance;
};

/// Returns why the first two channels of a format cannot be analysed as a pair, or nothing.
std::optional<PairError> pair_problem(const FrameFormat& format,
                                      const SafetyComparison& comparison = {});

/// The first channel is the control word, the second one the safety word.
/// \pre pair_problem() returns nothing
PairWeights pair_weights(const FrameFormat& format, const SafetyComparison& comparison = {});

/// Returns a human-readable text.
const char* text_of(PairError error);

/// The bit error rate of IEC 61784-3 for which a rating holds.
inline constexpr double rated_bit_error_rate = 1e-2;

/// The share of frames with an undetected error at rated_bit_error_rate.
struct UndetectedShares {
  /// The compared bits are wrong by more than the tolerance: in the CPW, as
  /// PairWeights::beyond_tolerance counts, and in the SPW, which holds the safe position.
  long double by_cpw = 0;
  long double by_spw = 0;
  /// Any bit of the CPW is wrong.
  long double control_position = 0;

  long double safe_position() const { return by_cpw > by_spw ? by_cpw : by_spw; }
};

/// The shares for the first two channels. Nothing if pair_problem() finds a problem.
std::optional<UndetectedShares> undetected_shares(const FrameFormat& format,
                                                  const SafetyComparison& comparison);

/// The rating of the first two channels with this comparison. Nothing if pair_problem() finds a
/// problem, or if the residual error is too large for a rating.
std::optional<SafetyRating> safety_rating(const FrameFormat& format,
                                          const SafetyComparison& comparison);

}  // namespace biss::lab
