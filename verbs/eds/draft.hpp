// A data sheet that is being written. Versions, lengths, identifiers, banks and checksums are
// derived if they are left out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/eds/bank.hpp"
#include "biss/eds/field.hpp"
#include "biss/frame/format.hpp"

namespace biss::verbs {

/// A part of which some bytes are given; the others are 0 until they are derived.
struct EdsPartDraft {
  EdsBank bank{};
  std::array<bool, eds_bank_bytes> given{};

  /// Sets a field and marks it as given. \pre the value fits the field
  void give(const EdsField& field, std::uint32_t value);
  /// Sets a field of this table unless it is given. \pre the value fits the field
  void derive(std::span<const EdsField> fields, std::string_view symbol, std::uint32_t value);
};

/// The parts of a data sheet. Profile parts have BP3's layout.
struct EdsDraft {
  std::optional<EdsPartDraft> common;
  /// By data channel.
  std::array<std::optional<EdsPartDraft>, max_channels> profiles;
  /// The bank of the common part, register 0x41.
  std::uint8_t eds_bank = 1;

  /// The bank of a channel's profile part: BANK_i; without common part channel i is in bank i.
  unsigned profile_bank(std::size_t channel) const;

  /// Derives CHKSUM, EDS_VER, EDS_LEN, DC_NUM, SL_NUM, BANK_i, DLEN_i and CPOLY_i of the common
  /// part, and CHKSUM, BP_VER, BP_LEN, BP_ID, FB1, FB2, POS_NUM and CPOLY of the profile parts, each
  /// unless it is given. Does not judge given values: see check_eds().
  void derive();

  /// The identifier for the registers 0x42 and 0x43. It belongs to the channel that this slave
  /// sends (SL_OFF), and has the length that the fields add up to, so that a wrong given BP_ID is
  /// not repeated. Empty if that channel has no profile part. \pre there is a common part, and
  /// derive() was called
  std::optional<std::uint16_t> identifier() const;

 private:
  std::uint32_t channels() const;
  void derive_common();
};

}  // namespace biss::verbs
