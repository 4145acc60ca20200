// What can be wrong with a frame format's text.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace biss {

/// One enumerator a mistake in the text of a frame format.
enum class FormatMistake : std::uint8_t {
  empty,
  unknown_item,
  unexpected_character,
  width_missing,
  width_zero,
  width_too_large,
  item_twice,
  position_twice,
  polarity_twice,
  data_after_crc,
  no_data_before_crc,
  too_many_data_bits,
  crc_width,
  polynomial_missing,
  number_needs_0x,
  number_without_digits,
  number_too_large,
  polynomial_form,
  start_too_large,
  too_many_channels,
  unknown_option,
  option_twice,
};

/// The mistake, and the index of the character it is at (the text's length when something is
/// missing at the end).
struct FormatTextError {
  FormatMistake mistake{};
  std::size_t at = 0;

  constexpr bool operator==(const FormatTextError&) const = default;
};

/// What a user is told, without a full stop.
constexpr std::string_view text_of(FormatMistake mistake) {
  constexpr std::array<std::string_view, 22> texts{
      "the format is empty",
      "no such item; items are posN, mtN, stN, padN, nE, nW, E, W, lcN, crcN",
      "unexpected character",
      "the number of bits is missing",
      "an item of 0 bits",
      "too many bits for this item",
      "this item stands in the channel already",
      "a channel has either pos or mt and st",
      "a flag has one polarity: nE or E, nW or W",
      "crc must be the last item of its channel",
      "crc has nothing to cover",
      "a channel carries at most 64 bits before its CRC",
      "a CRC has 3 to 16 bits",
      "this CRC width has no usual polynomial; write crcN:0x…",
      "write the number as 0x…",
      "hexadecimal digits are missing",
      "the number is too large",
      "the polynomial must be in full form: as wide as the CRC says, top and bottom bit 1",
      "the start value is wider than the CRC",
      "a frame has at most 8 channels",
      "no such option; the option is cds0",
      "this option stands in the format already"};
  return texts[static_cast<std::size_t>(mistake)];
}

}  // namespace biss
