// Derives what a data sheet leaves out from what it gives: versions, lengths, identifiers, banks and
// checksums.
//
//     EdsDraft draft;
//     draft.profiles[0].emplace().give(*find_field(bp3_fields, "FI_LEN"), 24);
//     derive_eds(draft);  // draft.profiles[0]->bank is complete
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/eds/bank.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"

namespace biss {

/// A part of which some bytes are given; the others are 0 until they are derived.
struct EdsPartDraft {
  EdsBank bank{};
  std::array<bool, eds_bank_bytes> given{};

  /// Sets a field and marks it as given. \pre the value fits the field
  constexpr void give(const EdsField& field, std::uint32_t value) {
    static_cast<void>(set_field(bank, field, value));
    for (std::size_t i = 0; i < field.bytes; ++i) given[field.address + i] = true;
  }
  /// Sets a field unless it is given. \pre the value fits the field
  constexpr void derive(const EdsField& field, std::uint32_t value) {
    if (!given[field.address]) static_cast<void>(set_field(bank, field, value));
  }
};

/// The parts of a data sheet that is being written. Profile parts have BP3's layout.
struct EdsDraft {
  std::optional<EdsPartDraft> common{};
  /// By data channel.
  std::array<std::optional<EdsPartDraft>, max_channels> profiles{};
  /// The bank of the common part, register 0x41.
  std::uint8_t eds_bank = 1;

  /// The bank of a channel's profile part: BANK_i; without common part channel i is in bank i.
  constexpr unsigned profile_bank(std::size_t channel) const {
    return common ? parse_common_part(common->bank).channels[channel].bank
                  : static_cast<unsigned>(channel);
  }
};

namespace eds_detail {

// The identifier of a BP3 channel with C = 0.
constexpr std::uint16_t plain_bp3_identifier(const Bp3Part& part) {
  return ProfileIdentifier{0x6200}.with_length(part.position_bits() + 2).raw;
}

constexpr void derive_profile(EdsPartDraft& draft) {
  const auto derive = [&draft](std::string_view symbol, std::uint32_t value) {
    draft.derive(*find_field(bp3_fields, symbol), value);
  };
  const Bp3Part usual;  // versions, feedback bits and polynomial as the profile states them
  derive("BP_VER", usual.bp_ver);
  derive("BP_LEN", usual.bp_len);
  derive("FB1", usual.fb1);
  derive("FB2", usual.fb2);
  derive("POS_NUM", usual.pos_num);
  derive("CPOLY", usual.cpoly);
  derive("BP_ID", plain_bp3_identifier(parse_bp3_part(draft.bank)));
  derive("CHKSUM", eds_checksum(draft.bank));
}

// Up to the last channel that has a profile part or a field in the common part.
constexpr std::uint32_t drafted_channels(const EdsDraft& draft) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < max_channels; ++i) {
    bool mentioned = draft.profiles[i].has_value();
    for (std::size_t k = 0; k < 4; ++k) {
      mentioned = mentioned || draft.common->given[common_channel_address(i) + k];
    }
    if (mentioned) count = i + 1;
  }
  return static_cast<std::uint32_t>(count);
}

constexpr void derive_common(EdsDraft& draft) {
  EdsPartDraft& common = *draft.common;
  const auto derive = [&common](std::string_view symbol, std::uint32_t value) {
    common.derive(*find_field(common_fields, symbol), value);
  };
  derive("EDS_VER", 1);
  derive("DC_NUM", drafted_channels(draft));
  derive("SL_NUM", 1);
  unsigned last_bank = draft.eds_bank;
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (!draft.profiles[i]) continue;
    const Bp3Part part = parse_bp3_part(draft.profiles[i]->bank);
    const auto& [bank, length, format, polynomial] = channel_symbols[i];
    derive(bank, (draft.eds_bank + 1U + static_cast<unsigned>(i)) & 0xFFU);
    derive(length, (part.position_bits() + 2) & 0xFFU);
    // A wider polynomial does not fit; with 0 the one of the profile part counts.
    derive(polynomial, part.cpoly <= 0xFF ? part.cpoly : 0);
    last_bank = std::max(last_bank, draft.profile_bank(i));
  }
  derive("EDS_LEN", (last_bank - draft.eds_bank + 1) & 0xFFU);
  derive("CHKSUM", eds_checksum(common.bank));
}

}  // namespace eds_detail

/// Derives CHKSUM, EDS_VER, EDS_LEN, DC_NUM, SL_NUM, BANK_i, DLEN_i and CPOLY_i of the common part,
/// and CHKSUM, BP_VER, BP_LEN, BP_ID, FB1, FB2, POS_NUM and CPOLY of the profile parts, each unless
/// it is given. Does not judge given values: see check_eds().
constexpr void derive_eds(EdsDraft& draft) {
  for (auto& profile : draft.profiles) {
    if (profile) eds_detail::derive_profile(*profile);
  }
  if (draft.common) eds_detail::derive_common(draft);
}

/// The identifier for the registers 0x42 and 0x43: that of the channel which this slave sends
/// (SL_OFF), with the length that its fields add up to, so that a wrong given BP_ID is not repeated.
/// Empty where that channel has no profile part. \pre draft.common, derive_eds() was called
constexpr std::optional<std::uint16_t> derived_identifier(const EdsDraft& draft) {
  const std::size_t own = parse_common_part(draft.common->bank).sl_off;
  if (own >= max_channels || !draft.profiles[own]) return std::nullopt;
  const Bp3Part part = parse_bp3_part(draft.profiles[own]->bank);
  const ProfileIdentifier given{part.bp_id};
  if (given.profile() != Profile::bp3) return eds_detail::plain_bp3_identifier(part);
  const unsigned length =
      part.position_bits() + 2 + (given.crc_is_data() ? unsigned{crc6.width_bits} : 0U);
  return given.with_length(length).raw;
}

}  // namespace biss
