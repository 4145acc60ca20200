// Checks a data sheet: each part alone, and the parts against each other and the registers.
//
//   check_eds(image, [](const biss::EdsFinding& finding) { print(finding); });
//
// It allocates and corrects nothing; a good data sheet gives no finding. A wrong field is reported
// if its own range or a contradiction shows it; otherwise the checksum only shows that the bank is
// damaged. The units of times are not checked: most of them are hypotheses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>

#include "biss/eds/bp3_check.hpp"
#include "biss/eds/common_check.hpp"
#include "biss/eds/image.hpp"

namespace biss {

namespace eds_detail {

// 0 of all bytes, or erased memory.
constexpr bool is_useless(const EdsBank& bank) {
  return is_filled_with(bank, 0x00) || is_filled_with(bank, 0xFF);
}

// The identifier of a channel: from the registers, else from its part; 0: not read.
constexpr ProfileIdentifier identifier_of(const EdsImage& image, std::size_t channel) {
  if (image.identifiers[channel].value_or(0) != 0) return {*image.identifiers[channel]};
  if (image.profiles[channel] == nullptr) return {};
  return {parse_bp3_part(*image.profiles[channel]).bp_id};
}

// Whether this is a safety encoder. An encoder counts as a standard encoder when every slave of the
// device has a channel with a known profile, and none is BP3S.
constexpr std::optional<bool> is_safety_encoder(const EdsImage& image) {
  bool all_known = image.common != nullptr;
  for (std::size_t i = 0; i < max_channels; ++i) {
    const Profile profile = identifier_of(image, i).profile();
    if (profile == Profile::bp3s) return true;
    const bool known =
        profile == Profile::bp0 || profile == Profile::bp1 || profile == Profile::bp3;
    all_known = all_known && (i >= channel_count(image) || known);
  }
  if (!all_known || channel_count(image) < parse_common_part(*image.common).sl_num) {
    return std::nullopt;
  }
  return false;
}

// Checks all parts of an image.
template <EdsSink Sink>
class ImageCheck {
 public:
  constexpr ImageCheck(const EdsImage& image, const EdsCheckOptions& given, Sink& sink)
      : image_(image), options_(given), sink_(sink) {}

  constexpr void run() {
    if (image_.common != nullptr) {
      check_common_part(*image_.common, sink_, image_.eds_bank, options_);
      if (!is_useless(*image_.common)) common_ = parse_common_part(*image_.common);
    }
    const std::optional<bool> safety = is_safety_encoder(image_);
    for (std::size_t i = 0; i < max_channels; ++i) check_profile(i, safety);
  }

 private:
  constexpr void check_profile(std::size_t i, std::optional<bool> safety) const {
    const EdsBank* bank = image_.profiles[i];
    const auto& registers = image_.identifiers[i];
    const CommonChannel* channel = common_ && i < common_->dc_num ? &common_->channels[i] : nullptr;
    if (bank == nullptr) {
      if (channel != nullptr && registers) compare_channel(*channel, i, {*registers}, nullptr);
      return;
    }
    if (profile_part(image_, i) == EdsPart::raw) return check_raw_part(i);
    Bp3Context context{static_cast<std::uint8_t>(i), registers, std::nullopt, safety};
    if (channel != nullptr) context.dlen = channel->dlen;
    check_bp3_part(*bank, sink_, context, options_);
    if (channel == nullptr || is_useless(*bank)) return;
    const Bp3Part part = parse_bp3_part(*bank);
    compare_channel(*channel, i, {registers.value_or(part.bp_id)}, &part);
  }

  constexpr void check_raw_part(std::size_t i) const {
    const PartCheck check(*image_.profiles[i], EdsPart::raw, static_cast<std::uint8_t>(i), options_,
                          sink_);
    if (check.check_filling("BP_VER")) return;
    const ProfileIdentifier id = identifier_of(image_, i);
    if (id.profile() == Profile::bp3s && crc_bit_is_wrong(id, true)) {
      check.report(EdsProblem::crc_bit, "BP_ID", id.raw);
    }
    // Assumed for the parts of other profiles, too.
    check.check_sum();
  }

  // Compares channel i of the common part with a BP3 part, or with the registers if the part was
  // not read. Differences of `length` and `polynomial` are reported only when the other side is
  // consistent.
  constexpr void compare_channel(const CommonChannel& channel, std::size_t i, ProfileIdentifier id,
                                 const Bp3Part* part) const {
    if (id.profile() != Profile::bp3 || !profile_channel(id.raw).ok()) return;
    const auto& symbols = channel_symbols[i];
    if (channel.actuator())
      report(EdsProblem::actuator, symbols[2], channel.format, "BP_ID", id.raw);
    const unsigned crc_bits = id.crc_is_data() ? crc6.width_bits : 0;
    const bool lengths_hold =
        part == nullptr || part->position_bits() + 2 + crc_bits == id.data_length();
    // With C = 1, the sources do not state whether DLEN_i counts the CRC, as DL does.
    const bool same =
        channel.dlen == id.data_length() || unsigned{channel.dlen} + crc_bits == id.data_length();
    if (!same && lengths_hold && channel.dlen != 0 && channel.dlen <= max_data_bits) {
      report(EdsProblem::data_length_differs, symbols[1], channel.dlen, "BP_ID", id.data_length());
    }
    constexpr std::uint32_t due = crc6.polynomial >> 1U;
    if (channel.cpoly == due || is_full_form_of_known(channel.cpoly)) return;
    if (channel.cpoly != 0 && stored_crc_bits(channel.cpoly) < min_crc_bits) return;
    if (channel.cpoly == 0 && id.crc_is_data()) return;
    if (part != nullptr && part->cpoly != due) return;
    report(EdsProblem::polynomial_differs, symbols[3], channel.cpoly, "CPOLY", due);
  }

  constexpr void report(EdsProblem problem, std::string_view symbol, std::uint32_t value,
                        std::string_view against, std::uint32_t expected) const {
    sink_(EdsFinding{EdsPart::common, 0, symbol, problem, value, against, expected});
  }

  const EdsImage& image_;
  const EdsCheckOptions& options_;
  Sink& sink_;
  std::optional<CommonPart> common_{};
};

}  // namespace eds_detail

/// Reports all findings of a data sheet: first the common part, then the channels. Parts that were
/// not read are not checked.
template <EdsSink Sink>
constexpr void check_eds(const EdsImage& image, Sink&& sink, const EdsCheckOptions& options = {}) {
  eds_detail::ImageCheck<std::remove_reference_t<Sink>>(image, options, sink).run();
}

}  // namespace biss
