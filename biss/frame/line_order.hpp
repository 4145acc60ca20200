// The one walk over the fields of a channel in the order of the line.
#pragma once

#include <cstdint>
#include <string_view>

#include "biss/base/bits.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss {

enum class FieldKind : std::uint8_t {
  position,
  multiturn,
  singleturn,
  life_counter,
  error,
  warning,
  padding,
};

/// Data bits of a channel that belong together.
struct LineField {
  FieldKind kind{};
  /// As in the text of a format: `pos`, `mt`, `st`, `lc`, `nE` or `E`, `nW` or `W`, `pad`.
  std::string_view name{};
  Field place{};
  bool gray = false;
  bool lsb = false;

  constexpr bool is_flag() const { return kind == FieldKind::error || kind == FieldKind::warning; }
  /// The value in a frame; a flag and padding as on the line.
  constexpr std::uint64_t value(const ChannelFormat& format, const Channel& channel,
                                std::uint64_t data) const {
    switch (kind) {
      case FieldKind::position:
        return channel.position;
      case FieldKind::multiturn:
        return format.singleturn.bits < 64 ? channel.position >> format.singleturn.bits : 0;
      case FieldKind::singleturn:
        return channel.position & low_mask(format.singleturn.bits);
      case FieldKind::life_counter:
        return channel.life_counter;
      default:
        return place.of(data);
    }
  }
};

/// The field that ends below bit `top`; without one a bit of padding. \pre top is not 0
constexpr LineField field_below(const ChannelFormat& channel, unsigned top) {
  const LineField fields[] = {
      {FieldKind::position, "pos", channel.position, channel.position_gray, channel.position_lsb},
      {FieldKind::multiturn, "mt", channel.multiturn, channel.multiturn_gray,
       channel.multiturn_lsb},
      {FieldKind::singleturn, "st", channel.singleturn, channel.singleturn_gray,
       channel.singleturn_lsb},
      {FieldKind::life_counter, "lc", channel.life_counter},
      {FieldKind::error, channel.error.active_high ? "E" : "nE", channel.error.place()},
      {FieldKind::warning, channel.warning.active_high ? "W" : "nW", channel.warning.place()}};
  for (const LineField& field : fields) {
    if (field.place.present() && unsigned{field.place.shift} + field.place.bits == top) {
      return field;
    }
  }
  return {FieldKind::padding, "pad", {static_cast<std::uint8_t>(top - 1), 1}};
}

/// Calls `visit` with each field of the data bits; neighbouring padding is one field.
template <class Visit>
constexpr void for_each_field(const ChannelFormat& channel, Visit&& visit) {
  for (unsigned top = channel.data_bits; top > 0;) {
    LineField field = field_below(channel, top);
    while (field.kind == FieldKind::padding && field.place.shift > 0 &&
           field_below(channel, field.place.shift).kind == FieldKind::padding) {
      --field.place.shift;
      ++field.place.bits;
    }
    visit(field);
    top = field.place.shift;
  }
}

}  // namespace biss
