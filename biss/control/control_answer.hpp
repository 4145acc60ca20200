// What the CDS bits of a control frame say, apart from data.
#pragma once

#include <bit>
#include <cstdint>
#include <optional>

#include "biss/control/control_error.hpp"
#include "biss/control/control_frame.hpp"

namespace biss {

/// How many slaves have taken an ID, from 0 on without a gap: 0…8, and 9 where there are more
/// (IDL8). \param cds the CDS bits 0…15 of a control frame, bit 0 topmost: IDL0 … IDL8 and seven
/// zeros \return nothing where no slaves can have sent this
constexpr std::optional<unsigned> slaves_counted(std::uint16_t cds) {
  const std::uint32_t zeros = ~std::uint32_t{cds} & 0xFFFFU;
  if ((zeros & (zeros + 1U)) != 0 || zeros < 0x7FU) return std::nullopt;
  return static_cast<unsigned>(std::countl_zero(zeros)) - 16U;
}

/// Bit k: the slave with ID k executes the command if EX = 1.
/// \param cds the CDS bits 16…23 of a control frame, IDA0 topmost
constexpr std::uint8_t slaves_accepting(std::uint8_t cds) {
  unsigned ida = cds;
  ida = (ida & 0x0FU) << 4U | ida >> 4U;
  ida = (ida & 0x33U) << 2U | (ida >> 2U & 0x33U);
  ida = (ida & 0x55U) << 1U | (ida >> 1U & 0x55U);
  return static_cast<std::uint8_t>(ida);
}

/// Why R and W as heard on CDS do not let the access go on; nothing where they do.
constexpr std::optional<ControlError> access_denied(RegisterAccess access, bool r, bool w) {
  if (access == RegisterAccess::read) {
    if (r && !w) return std::nullopt;
    if (r) return ControlError::refused;
    return w ? ControlError::rw_pattern : ControlError::unheard;
  }
  if (r) return ControlError::rw_pattern;
  if (w) return std::nullopt;
  return ControlError::refused_or_unheard;
}

}  // namespace biss
