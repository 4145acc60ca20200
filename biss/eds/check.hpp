// Judges a data sheet: each part alone, and the parts against each other and the registers.
//
//   check_eds(image, [](const biss::EdsFinding& found) { … });
//
// Nothing is allocated, nothing is corrected; a good data sheet gives no finding. A field that is
// wrong is reported where its own range or a contradiction tells; else the checksum tells that the
// bank is damaged somewhere. Units of time are not judged: most of them are hypotheses.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "biss/eds/check_bp3.hpp"
#include "biss/eds/check_common.hpp"
#include "biss/eds/finding.hpp"
#include "biss/eds/image.hpp"

namespace biss {
namespace eds_detail {

constexpr bool is_useless(const EdsBank& bank) {
  return is_filled_with(bank, 0x00) || is_filled_with(bank, 0xFF);
}

// What channel i of the common part says of a BP3 part, or of the registers where that was not
// read. `length` and `polynomial` are reported against the common part only when the other side is
// sound by itself.
template <class Report>
constexpr void check_channel_against(const CommonChannel& channel, std::size_t i,
                                     ProfileIdentifier id, const Bp3Part* part,
                                     const EdsCheckOptions& options, const Report& report) {
  if (id.profile() != Profile::bp3 || !profile_channel(id.raw).ok()) return;
  const auto& symbols = channel_symbols[i];
  if (channel.actuator()) report(EdsProblem::actuator, symbols[2], channel.format, "BP_ID", id.raw);
  const bool counted = id.crc_is_data() && options.length_counts_crc;
  const unsigned crc_bits = counted ? crc6.width_bits : 0;
  const bool lengths_hold =
      part == nullptr || part->position_bits() + 2 + crc_bits == id.data_length();
  // With C = 1 the sources do not say whether DLEN_i counts the CRC, which DL does.
  const bool same = channel.dlen == id.data_length() ||
                    (counted && unsigned{channel.dlen} + crc_bits == id.data_length());
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

constexpr bool sends_safety_word(const EdsImage& image) {
  for (std::size_t i = 0; i < max_channels; ++i) {
    std::uint16_t id = image.identifiers[i].value_or(0);
    if (image.profiles[i] != nullptr && !image.identifiers[i]) {
      id = parse_bp3_part(*image.profiles[i]).bp_id;
    }
    if (ProfileIdentifier{id}.profile() == Profile::bp3s) return true;
  }
  return false;
}

template <class Sink>
constexpr void check_raw_part(const EdsBank& bank, std::size_t channel, Sink& sink,
                              const EdsCheckOptions& options) {
  const PartReport<Sink> report{sink, EdsPart::raw, static_cast<std::uint8_t>(channel)};
  if (check_filling(bank, "BP_VER", report)) return;
  if (options.raw_checksum) check_sum(bank, report);
}

template <class Sink>
constexpr void check_profile(const EdsImage& image, std::size_t i, const CommonPart* common,
                             bool safety, Sink& sink, const EdsCheckOptions& options) {
  const EdsBank* bank = image.profiles[i];
  const PartReport<Sink> report{sink};
  const CommonChannel* channel =
      common != nullptr && i < common->dc_num && i < max_channels ? &common->channels[i] : nullptr;
  if (bank == nullptr) {
    if (channel != nullptr && image.identifiers[i]) {
      check_channel_against(*channel, i, {*image.identifiers[i]}, nullptr, options, report);
    }
    return;
  }
  if (profile_part(image, i) == EdsPart::raw) {
    check_raw_part(*bank, i, sink, options);
    return;
  }
  Bp3Context context{static_cast<std::uint8_t>(i), image.identifiers[i], std::nullopt, safety};
  if (channel != nullptr) context.dlen = channel->dlen;
  check_bp3_part(*bank, sink, context, options);
  if (channel == nullptr || is_useless(*bank)) return;
  const Bp3Part part = parse_bp3_part(*bank);
  const ProfileIdentifier id{image.identifiers[i].value_or(part.bp_id)};
  check_channel_against(*channel, i, id, &part, options, report);
}

}  // namespace eds_detail

/// Reports all that is wrong with a data sheet, the common part's findings first, then the
/// channels'. What was not read is not judged.
template <EdsSink Sink>
constexpr void check_eds(const EdsImage& image, Sink&& sink, const EdsCheckOptions& options = {}) {
  CommonPart common;
  const bool common_read = image.common != nullptr && !eds_detail::is_useless(*image.common);
  if (image.common != nullptr) {
    check_common_part(*image.common, sink, image.eds_bank, options);
    common = parse_common_part(*image.common);
  }
  const bool safety = eds_detail::sends_safety_word(image);
  for (std::size_t i = 0; i < max_channels; ++i) {
    eds_detail::check_profile(image, i, common_read ? &common : nullptr, safety, sink, options);
  }
}

}  // namespace biss
