// What the comparison of two positions lets through, when some of the compared bits are wrong.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "biss/frame/format.hpp"

namespace biss::lab {

/// A bit of the control word and the bit of the safety word that must agree with it; both count
/// from the last data bit of their word.
struct ComparedBit {
  std::uint8_t control_shift = 0;
  std::uint8_t safety_shift = 0;
};

/// The bits of both positions that stand for the same, the weightiest first: singleturn (or `pos`)
/// aligned at its top, turns at their last bit (facts: the fact sheet, 5.3). Turns and singleturn
/// are one number, so that a carry between them is no difference. `singleturn_bits` of the
/// singleturn (ACC_MIN), 0: as many as both have. Empty when nothing can be compared, and for Gray
/// code. \param turns compare turns too, where both words have some
std::vector<ComparedBit> compared_bits(const ChannelFormat& control, const ChannelFormat& safety,
                                       unsigned singleturn_bits, bool turns);

/// Which of `bits` compared bits are wrong, by the share of positions for which that passes: the
/// true position is evenly distributed, and the two values as read differ by `tolerance` at most,
/// modulo 2^bits. Masks that never pass are not listed. All shares are exact.
/// \pre bits is 1…64, tolerance less than 2^(bits-1), and small: it is all tried
std::map<std::uint64_t, long double> passing_masks(unsigned bits, unsigned tolerance);

/// The bits that are wrong in the control word and in the safety word.
struct MaskPair {
  std::uint64_t control = 0;
  std::uint64_t safety = 0;

  constexpr auto operator<=>(const MaskPair&) const = default;
};

/// The same for both words: the two values pass, and the control word's is within the tolerance of
/// the true one. The share of positions for which that is so.
std::map<MaskPair, long double> harmless_masks(unsigned bits, unsigned tolerance);

}  // namespace biss::lab
