// Faults that shift or replace bits of a frame: a bit lost, doubled or inserted, a line that is
// stuck, a gap, START too early or too late. The share of all positions that passes although the
// position is wrong is counted exactly, for every place.
//
// Every bit on the line is an XOR of data bits and a constant (a CRC is linear), and so is every
// check. So with c independent conditions, exactly 2^-c of all data words pass, or none.
#pragma once

#include <array>

#include "biss/frame/format.hpp"
#include "lab/campaign_fault.hpp"
#include "lab/pair.hpp"

namespace biss::lab {

/// The kinds that are analysed. A place counts clocks from START, which is 0; CDS is 1, the first
/// data bit 2, and STOP follows the last CRC bit. The place of false_start counts clocks before
/// START.
inline constexpr std::array<FaultKind, 10> structural_faults{
    FaultKind::lost_bit,      FaultKind::doubled_bit, FaultKind::inserted_low,
    FaultKind::inserted_high, FaultKind::slo_low,     FaultKind::slo_high,
    FaultKind::gap_low,       FaultKind::gap_high,    FaultKind::lost_start,
    FaultKind::false_start};

/// The encoder is healthy: the flags show "no error, no warning", padding is 0, position and
/// counter bits are independent and evenly distributed. The reader reads as many bits as a frame
/// has, and STOP; the line is low after STOP.
struct StructureModel {
  /// The compared bits of the safety word are the position bits of the control word.
  bool pair = false;
  SafetyComparison comparison = {};
  bool cds = false;  ///< as sent by the encoder
  unsigned gap_bits = 8;
};

/// Shares of positions that pass although the first channel's position is wrong. Each check is made
/// in addition to those before it.
struct PassedShares {
  long double first_word = 0;  ///< STOP, CDS if known, and the first channel's checksum
  long double all_words = 0;   ///< all other checksums
  long double trusted = 0;     ///< nE shows "no error" in all channels
  long double pair = 0;        ///< the counter is the expected one and the comparison passes
};

/// One fault at one place. \pre fault is one of structural_faults
PassedShares passed_shares(const FrameFormat& format, FaultKind fault, unsigned place,
                           const StructureModel& model);

/// The shares of frames with a fault that the checksum of one word, the checksum of the other, both
/// checksums and the monitor accept, and the shares with a wrong position: in the order of
/// Acceptance.
using AcceptedShares = std::array<long double, 5>;

/// A fault of a campaign other than flips, at its place or at any place with the same probability.
/// Words are sent as CampaignFrame::encode() does, with any position and any counter.
/// \pre pair_problem() returns nothing for this format and setup
AcceptedShares accepted_shares(const FrameFormat& format, const SafetySetup& setup,
                               const FaultChoice& fault);

/// One fault at all possible places. `sum` is over the places: a fault that is equally likely at
/// each place passes with the share sum / places. For lost_start the places exclude each other (the
/// next 1 counts), so the sum itself is the share.
struct StructureRow {
  FaultKind fault{};
  unsigned places = 0;
  PassedShares sum;
  PassedShares worst;
  /// The place with the highest share of the first word.
  unsigned worst_place = 0;
};

StructureRow structure_row(const FrameFormat& format, FaultKind fault, const StructureModel& model);

}  // namespace biss::lab
