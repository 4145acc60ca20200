// The format of one data channel, from whatever the data sheet and the registers say of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/eds/check_field.hpp"
#include "biss/eds/profile.hpp"
#include "biss/eds/reader.hpp"
#include "biss/eds/remark.hpp"
#include "biss/frame/format.hpp"

namespace biss::eds_detail {

// The CRC of a polynomial stored without its lowest bit; no CRC when none of 3 to 16 bits.
constexpr CrcSpec crc_of_stored(std::uint32_t stored, std::uint32_t start) {
  const unsigned width = stored_crc_bits(stored);
  if (width < min_crc_bits || width > max_crc_bits) return {};
  return {.polynomial = stored << 1U | 1U,
          .start = static_cast<std::uint16_t>(start),
          .width_bits = static_cast<std::uint8_t>(width)};
}

template <class Sink>
class ChannelReader {
 public:
  using Answer = Result<ChannelFormat, EdsDeviceError>;

  constexpr ChannelReader(const EdsReader& reader, std::size_t index,
                          const EdsDeviceOptions& options, Sink& sink)
      : reader_(reader),
        index_(index),
        options_{options.check_crc_in_data, options.length_counts_crc},
        sink_(sink) {
    const EdsImage& image = reader.image();
    if (image.common != nullptr) common_ = reader.common().channels[index];
    if (image.profiles[index] == nullptr) return;
    if (profile_part(image, index) == EdsPart::bp3) {
      part_ = reader.bp3(index);
    } else {
      raw_ = reader.bp3(index);
    }
  }

  constexpr Answer run() {
    if (common_ && common_->actuator()) return fail(EdsDeviceCause::actuator);
    const std::uint16_t identifier = chosen_identifier();
    const auto channel = profile_channel(identifier, options_);
    if (!channel.ok()) {
      if (identifier != 0) remark_part(EdsRemarkKind::not_usable, "BP_ID", identifier, 0);
      return from_lengths();
    }
    const ProfileIdentifier id{identifier};
    if (!doubt_of(id).empty()) {
      remark_part(EdsRemarkKind::doubtful, "BP_ID", identifier, identifier);
    }
    ChannelFormat format = *channel;
    if (id.profile() == Profile::bp3 && part_) refine(format);
    compare_with_common(id, format);
    if (raw_) use_raw_crc(format);
    return format;
  }

 private:
  constexpr Answer fail(EdsDeviceCause cause) const {
    return failure(EdsDeviceError{cause, static_cast<std::uint8_t>(index_)});
  }
  constexpr void remark(EdsPart part, EdsRemarkKind kind, std::string_view symbol,
                        std::uint32_t stored, std::uint32_t used) const {
    sink_(EdsRemark{part, static_cast<std::uint8_t>(index_), symbol, kind, stored, used});
  }
  constexpr void remark_part(EdsRemarkKind kind, std::string_view symbol, std::uint32_t stored,
                             std::uint32_t used) const {
    remark(raw_ ? EdsPart::raw : EdsPart::bp3, kind, symbol, stored, used);
  }
  constexpr bool common_overrides(unsigned which) const {
    return reader_.overrides(EdsPart::common, 0, channel_symbols[index_][which]);
  }

  // What is set by hand first, then the registers, then the bank. A DLEN_i set by hand replaces DL.
  constexpr std::uint16_t chosen_identifier() const {
    const auto registers = reader_.image().identifiers[index_];
    std::uint16_t stored = part_ ? part_->bp_id : raw_ ? raw_->bp_id : std::uint16_t{0};
    if (is_swapped_bp3(stored)) {
      const auto meant = static_cast<std::uint16_t>(bytes_swapped(stored, 2));
      remark_part(EdsRemarkKind::repaired, "BP_ID", stored, meant);
      stored = meant;
    }
    std::uint16_t used = stored;
    if (registers && *registers != 0 &&
        !(part_ && reader_.overrides(EdsPart::bp3, index_, "BP_ID"))) {
      used = *registers;
      if ((part_ || raw_) && used != stored) {
        remark_part(EdsRemarkKind::disagrees, "BP_ID", stored, used);
      }
    }
    const ProfileIdentifier id{used};
    if (common_ && common_overrides(1) && id.profile() == Profile::bp3) {
      const bool counted = id.crc_is_data() && options_.length_counts_crc;
      const unsigned length = common_->dlen + (counted ? crc6.width_bits : 0U);
      used = static_cast<std::uint16_t>((used & 0xFF80U) | (length & 0x7FU));
    }
    return used;
  }

  // Without a usable identifier: the lengths of the BP3 part, else DLEN_i with its two flags.
  constexpr Answer from_lengths() {
    const bool by_hand = common_ && common_overrides(1);
    if (part_ && !by_hand && part_->position_bits() >= 1 &&
        part_->position_bits() + 2 <= bp3_max_data_bits) {
      ChannelFormat format = position_channel(part_->position_bits(), 0, 0, crc6);
      refine(format);
      return format;
    }
    if (!common_ || common_->dlen == 0 || common_->dlen > max_data_bits) {
      return fail(EdsDeviceCause::unknown_channel);
    }
    ChannelFormat format;
    format.data_bits = common_->dlen;
    if (common_->dlen >= 2) format = position_channel(common_->dlen - 2U, 0, 0, {});
    format.crc =
        crc_of_stored(repaired(EdsPart::common, channel_symbols[index_][3], common_->cpoly), 0);
    if (raw_) {
      use_raw_crc(format);
    } else if (!format.crc.present()) {
      remark(EdsPart::common, EdsRemarkKind::not_given, channel_symbols[index_][3], common_->cpoly,
             0);
    }
    return format;
  }

  constexpr void refine(ChannelFormat& format) const {
    divide(format);
    set_flags(format);
    if (!format.crc.present()) return;
    const std::uint32_t stored = repaired(EdsPart::bp3, "CPOLY", part_->cpoly);
    const CrcSpec crc = crc_of_stored(stored, part_->cstart);
    if (!crc.present()) {
      remark(EdsPart::bp3, EdsRemarkKind::not_usable, "CPOLY", part_->cpoly, 0);
    } else {
      format.crc = crc;
    }
    if (part_->cstart > format.crc.mask()) {
      remark(EdsPart::bp3, EdsRemarkKind::not_usable, "CSTART", part_->cstart, 0);
      format.crc.start = 0;
    }
  }

  // Turns above singleturn, where the lengths fit; a scale has no turns.
  constexpr void divide(ChannelFormat& format) const {
    if (part_->position_bits() != format.position.bits) {
      remark(EdsPart::bp3, EdsRemarkKind::undivided, "MT_LEN", part_->position_bits(),
             format.position.bits);
      return;
    }
    const unsigned singleturn = unsigned{part_->co_len} + part_->fi_len;
    if (part_->linear() || part_->mt_len == 0) return;
    const std::uint8_t shift = format.position.shift;
    format.position = {};
    if (singleturn != 0) format.singleturn = {shift, static_cast<std::uint8_t>(singleturn)};
    format.multiturn = {static_cast<std::uint8_t>(shift + singleturn), part_->mt_len};
  }

  // Table B: 1 is nE, 2 is nW, 0 any value.
  constexpr void set_flags(ChannelFormat& format) const {
    const std::uint8_t first = format.error.shift;
    const std::uint8_t second = format.warning.shift;
    if (part_->fb1 > 2 || part_->fb2 > 2 || (part_->fb1 == part_->fb2 && part_->fb1 != 0)) {
      const bool first_wrong = part_->fb1 != 1;
      remark(EdsPart::bp3, EdsRemarkKind::not_usable, first_wrong ? "FB1" : "FB2",
             first_wrong ? part_->fb1 : part_->fb2, 0);
      return;
    }
    const auto flag = [&](unsigned function) -> FlagField {
      if (part_->fb1 == function) return {.shift = first, .present = true};
      if (part_->fb2 == function) return {.shift = second, .present = true};
      return {};
    };
    format.error = flag(1);
    format.warning = flag(2);
  }

  // A polynomial in full form, or with its bytes turned round, as what it was meant to be.
  constexpr std::uint32_t repaired(EdsPart part, std::string_view symbol,
                                   std::uint32_t stored) const {
    std::uint32_t meant = stored;
    if (is_full_form_of_known(stored)) meant = stored >> 1U;
    if (part == EdsPart::bp3 && bytes_swapped(stored, 4) == crc6.polynomial >> 1U) {
      meant = crc6.polynomial >> 1U;
    }
    if (meant != stored) remark(part, EdsRemarkKind::repaired, symbol, stored, meant);
    return meant;
  }

  // The profile is believed, unless the common part's field is set by hand.
  constexpr void compare_with_common(ProfileIdentifier id, ChannelFormat& format) const {
    if (!common_) return;
    const auto& symbols = channel_symbols[index_];
    // With C = 1 the sources do not say whether DLEN_i counts the CRC.
    const bool same =
        common_->dlen == format.data_bits ||
        (id.crc_is_data() && common_->dlen == id.data_length()) ||
        (id.crc_is_data() && unsigned{common_->dlen} + crc6.width_bits == id.data_length());
    if (!same && common_->dlen != 0) {
      remark(EdsPart::common, EdsRemarkKind::disagrees, symbols[1], common_->dlen,
             format.data_bits);
    }
    if (!format.crc.present() || common_->cpoly == 0) return;
    if (common_overrides(3)) {
      const CrcSpec crc = crc_of_stored(common_->cpoly, format.crc.start);
      if (crc.present()) format.crc = crc;
    } else if (common_->cpoly != format.crc.polynomial >> 1U) {
      remark(EdsPart::common, EdsRemarkKind::disagrees, symbols[3], common_->cpoly,
             format.crc.polynomial >> 1U);
    }
  }

  // NXP's driver reads CPOLY and CSTART at BP3's addresses whatever the profile.
  constexpr void use_raw_crc(ChannelFormat& format) const {
    if (raw_->cpoly == 0 || raw_->cpoly == format.crc.polynomial >> 1U) return;
    const CrcSpec crc = crc_of_stored(raw_->cpoly, raw_->cstart);
    // A format that carries its CRC as data keeps it so, and a start value must fit.
    const bool carried = !format.crc.present() && format.life_counter.present();
    if (!crc.present() || carried || raw_->cstart > crc.mask()) return;
    remark(EdsPart::raw, EdsRemarkKind::hypothesis, "CPOLY", raw_->cpoly, raw_->cpoly);
    format.crc = crc;
  }

  const EdsReader& reader_;
  std::size_t index_;
  ProfileOptions options_;
  Sink& sink_;
  std::optional<CommonChannel> common_{};
  std::optional<Bp3Part> part_{};
  std::optional<Bp3Part> raw_{};  // read as if it had BP3's layout, for its CRC only
};

}  // namespace biss::eds_detail
