// A data sheet that is being written. Versions, lengths, identifiers, banks and checksums are
// derived if they are left out.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/field.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"

namespace biss::verbs {

/// A part of which some bytes are given; the others are 0 until they are derived.
struct EdsPartDraft {
  EdsBank bank{};
  std::array<bool, eds_bank_bytes> given{};

  /// Sets a field and marks it as given. \pre the value fits the field
  void give(const EdsField& field, std::uint32_t value) {
    static_cast<void>(set_field(bank, field, value));
    std::fill_n(given.begin() + field.address, field.bytes, true);
  }
  /// Sets a field of this table unless it is given. \pre the value fits the field
  void derive(std::span<const EdsField> fields, std::string_view symbol, std::uint32_t value) {
    const EdsField& field = *find_field(fields, symbol);
    if (!given[field.address]) static_cast<void>(set_field(bank, field, value));
  }
};

/// The parts of a data sheet. Profile parts have BP3's layout.
struct EdsDraft {
  std::optional<EdsPartDraft> common;
  /// By data channel.
  std::array<std::optional<EdsPartDraft>, max_channels> profiles;
  /// The bank of the common part, register 0x41.
  std::uint8_t eds_bank = 1;

  /// The bank of a channel's profile part: BANK_i; without common part channel i is in bank i.
  unsigned profile_bank(std::size_t channel) const {
    return common ? parse_common_part(common->bank).channels[channel].bank
                  : static_cast<unsigned>(channel);
  }

  /// Derives CHKSUM, EDS_VER, EDS_LEN, DC_NUM, SL_NUM, BANK_i, DLEN_i and CPOLY_i of the common
  /// part, and CHKSUM, BP_VER, BP_LEN, BP_ID, FB1, FB2, POS_NUM and CPOLY of the profile parts, each
  /// unless it is given. Does not judge given values: see check_eds().
  void derive() {
    for (auto& profile : profiles) {
      if (profile) derive_profile(*profile);
    }
    if (common) derive_common();
  }

  /// The identifier for the registers 0x42 and 0x43. It belongs to the channel that this slave
  /// sends (SL_OFF), and has the length that the fields add up to, so that a wrong given BP_ID is
  /// not repeated. Empty if that channel has no profile part. \pre there is a common part, and
  /// derive() was called
  std::optional<std::uint16_t> identifier() const {
    const std::size_t own = parse_common_part(common->bank).sl_off;
    if (own >= max_channels || !profiles[own]) return std::nullopt;
    const Bp3Part part = parse_bp3_part(profiles[own]->bank);
    const ProfileIdentifier given{part.bp_id};
    if (given.profile() != Profile::bp3) return plain_identifier(part);
    const unsigned crc_bits = given.crc_is_data() ? crc6.width_bits : 0;
    return given.with_length(part.position_bits() + 2 + crc_bits).raw;
  }

 private:
  // The identifier of a BP3 channel with C = 0.
  static std::uint16_t plain_identifier(const Bp3Part& part) {
    return ProfileIdentifier{0x6200}.with_length(part.position_bits() + 2).raw;
  }

  static void derive_profile(EdsPartDraft& draft) {
    const EdsBank usual = build_bank(Bp3Part{});
    for (const std::string_view symbol : {"BP_VER", "BP_LEN", "FB1", "FB2", "POS_NUM", "CPOLY"}) {
      draft.derive(bp3_fields, symbol, field_value(usual, *find_field(bp3_fields, symbol)));
    }
    draft.derive(bp3_fields, "BP_ID", plain_identifier(parse_bp3_part(draft.bank)));
    draft.derive(bp3_fields, "CHKSUM", eds_checksum(draft.bank));
  }

  void derive_common() {
    const auto derive = [this](std::string_view symbol, std::uint32_t value) {
      common->derive(common_fields, symbol, value);
    };
    derive("EDS_VER", 1);
    derive("DC_NUM", channels());
    derive("SL_NUM", 1);
    unsigned last_bank = eds_bank;
    for (std::size_t i = 0; i < max_channels; ++i) {
      if (!profiles[i]) continue;
      const Bp3Part part = parse_bp3_part(profiles[i]->bank);
      const auto& [bank, length, format, polynomial] = eds_detail::channel_symbols[i];
      derive(bank, (eds_bank + 1U + static_cast<unsigned>(i)) & 0xFFU);
      derive(length, (part.position_bits() + 2) & 0xFFU);
      // A wider polynomial does not fit; with 0 the one of the profile part counts.
      derive(polynomial, part.cpoly <= 0xFF ? std::uint32_t{part.cpoly} : 0);
      last_bank = std::max(last_bank, profile_bank(i));
    }
    derive("EDS_LEN", (last_bank - eds_bank + 1) & 0xFFU);
    derive("CHKSUM", eds_checksum(common->bank));
  }

  // Up to the last channel that has a profile part or a field in the common part.
  std::uint32_t channels() const {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < max_channels; ++i) {
      const auto first = common->given.begin() + common_channel_address(i);
      if (profiles[i] || std::count(first, first + 4, true) != 0) count = i + 1;
    }
    return count;
  }
};

}  // namespace biss::verbs
