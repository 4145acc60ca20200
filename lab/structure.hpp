// Faults that no bit error makes: a bit lost, doubled or inserted, a line that is stuck, START
// too early or too late, a gap. Which share of all positions passes with a wrong one is counted
// exactly, for every place.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "biss/frame/format.hpp"
#include "lab/pair.hpp"

namespace biss::lab {

/// What happens at a place. Places count clocks from START, which is 0; CDS is 1, the first data
/// bit 2, STOP comes behind the last CRC bit.
enum class StructuralFault : std::uint8_t {
  lost_bit,       ///< the bit is not seen: an edge of MA too many at the encoder
  doubled_bit,    ///< the bit is seen twice: an edge of MA too few at the encoder
  inserted_low,   ///< a 0 is seen before the bit
  inserted_high,  ///< a 1 is seen before the bit
  stuck_low,      ///< 0 from the bit on
  stuck_high,     ///< 1 from the bit on, as when the cable is cut
  gap_low,        ///< `gap_bits` bits from this one on read 0, then the frame goes on
  gap_high,       ///< the same with 1
  late_start,     ///< START reads 0 and the 1 at the place is taken for it
  early_start,    ///< a bit of ACK reads 1, so many clocks before START, and is taken for it
};

inline constexpr StructuralFault structural_faults[] = {
    StructuralFault::lost_bit,      StructuralFault::doubled_bit, StructuralFault::inserted_low,
    StructuralFault::inserted_high, StructuralFault::stuck_low,   StructuralFault::stuck_high,
    StructuralFault::gap_low,       StructuralFault::gap_high,    StructuralFault::late_start,
    StructuralFault::early_start};

/// The enumerator's name.
std::string_view name_of(StructuralFault fault);

/// The encoder is healthy: flags say "no error, no warning", padding is 0, position and counter
/// bits are independent and evenly distributed. The reader looks at as many bits as a frame has and
/// at STOP, and the line is low behind it.
struct StructureModel {
  /// The safety word carries the control word's position where the two are compared.
  bool pair = false;
  PairChecks checks = {};
  bool cds = false;  ///< as the encoder sends it
  unsigned gap_bits = 8;
};

/// Shares of positions that pass although the first channel's position is wrong. The counted events
/// grow rarer from one to the next.
struct PassedShares {
  long double first_word = 0;  ///< STOP, CDS where known, and the first channel's checksum
  long double all_words = 0;   ///< and all other checksums
  long double trusted = 0;     ///< and nE says "no error" in all channels
  long double pair = 0;        ///< and the counter is the expected one and the comparison passes
};

/// One fault at one place.
PassedShares passed_shares(const FrameFormat& format, StructuralFault fault, unsigned place,
                           const StructureModel& model);

/// One fault over all places at which it can be. `sum` is over the places; a fault that is equally
/// likely at each passes with the share sum / places. For late_start the places exclude each other
/// (it is the next 1 that counts), so that the sum itself is the share.
struct StructureRow {
  StructuralFault fault{};
  unsigned places = 0;
  PassedShares sum;
  PassedShares worst;
  /// Where the first word's share is highest.
  unsigned worst_place = 0;
};

StructureRow structure_row(const FrameFormat& format, StructuralFault fault,
                           const StructureModel& model);

}  // namespace biss::lab
