// Faults that are no independent flips, for bits that are anything with XOR: one frame's bits, or
// what each bit depends on.
#pragma once

#include <cstdint>

#include "lab/campaign_fault.hpp"

namespace biss::lab {

/// Both words and STOP; bit 0 is STOP.
__extension__ using LineWord = unsigned __int128;

/// How many places a fault can begin at, in a payload of so many bits.
/// 0: it is too long for them.
constexpr unsigned places_of(const FaultChoice& fault, unsigned payload_bits) {
  switch (fault.kind) {
    case CampaignFault::burst:
      return fault.length_bits > payload_bits ? 0 : payload_bits - fault.length_bits + 1U;
    case CampaignFault::early_start:  // further away only zeros are read
      return payload_bits + 1U;
    case CampaignFault::late_start:
    case CampaignFault::cds_high:
    case CampaignFault::stop_high:
      return 1;
    default:
      return payload_bits;
  }
}

/// The line after the fault; as it is where the fault is none of these bits.
/// \param size_bits payload and STOP
/// \param place bits from the front of the payload
/// \param pattern burst: its lower bits are those between the first and the last one
constexpr LineWord damaged(LineWord line, unsigned size_bits, const FaultChoice& fault,
                           unsigned place, std::uint64_t pattern) {
  const unsigned after = size_bits - place;  // bits from the place on
  const LineWord tail = (LineWord{1} << after) - 1U;
  const LineWord level = is_high(fault.kind) ? ~LineWord{0} : 0;
  switch (fault.kind) {
    case CampaignFault::flips:
    case CampaignFault::late_start:
    case CampaignFault::early_start:
    case CampaignFault::cds_high:
      return line;
    case CampaignFault::stop_high:
      return line | 1U;
    case CampaignFault::burst: {
      const unsigned inside = fault.length_bits - 2U;
      const LineWord between = pattern & ((std::uint64_t{1} << inside) - 1U);
      const LineWord wrong = (LineWord{1} << (fault.length_bits - 1U)) | (between << 1U) | 1U;
      return line ^ (wrong << (after - fault.length_bits));
    }
    case CampaignFault::lost_clock:  // behind STOP the line is low
      return (line & ~tail) | ((line << 1U) & tail);
    case CampaignFault::double_clock:
    case CampaignFault::inserted_low:
    case CampaignFault::inserted_high: {
      const LineWord rest = tail >> 1U;
      const LineWord first = fault.kind == CampaignFault::double_clock ? line : level;
      return (line & ~tail) | (first & tail & ~rest) | ((line >> 1U) & rest);
    }
    case CampaignFault::gap_low:
    case CampaignFault::gap_high: {
      const LineWord behind = fault.length_bits >= after ? 0 : tail >> fault.length_bits;
      return (line & ~(tail & ~behind)) | (level & tail & ~behind);
    }
    case CampaignFault::slo_low:
    case CampaignFault::slo_high:
      return (line & ~tail) | (level & tail);
  }
  return line;
}

}  // namespace biss::lab
