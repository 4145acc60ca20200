// A data sheet with single fields overridden.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "biss/base/result.hpp"
#include "biss/eds/bp3_part.hpp"
#include "biss/eds/common_part.hpp"
#include "biss/eds/image.hpp"
#include "biss/eds/remark.hpp"

namespace biss::eds_detail {

class EdsReader {
 public:
  constexpr EdsReader(const EdsImage& image, std::span<const EdsOverride> overrides)
      : image_(image), overrides_(overrides) {}

  constexpr const EdsImage& image() const { return image_; }

  // Whether every override can be made; says what it replaces.
  template <class Sink>
  constexpr Result<bool, EdsDeviceError> announce(Sink& sink) const {
    for (std::size_t i = 0; i < overrides_.size(); ++i) {
      const EdsOverride& each = overrides_[i];
      const auto index = static_cast<std::uint8_t>(i);
      const EdsField* field = find_field(fields_of(each.part), each.symbol);
      if (field == nullptr || each.value > field->all_ones()) {
        return failure(EdsDeviceError{EdsDeviceCause::unknown_override, index});
      }
      const EdsBank* bank = bank_of(each);
      if (bank == nullptr) return failure(EdsDeviceError{EdsDeviceCause::override_unread, index});
      sink(EdsRemark{each.part, each.channel, field->symbol, EdsRemarkKind::overridden,
                     field_value(*bank, *field), each.value});
    }
    return true;
  }

  constexpr bool overrides(EdsPart part, std::size_t channel, std::string_view symbol) const {
    for (const EdsOverride& each : overrides_) {
      if (each.part == part && (part == EdsPart::common || each.channel == channel) &&
          each.symbol == symbol) {
        return true;
      }
    }
    return false;
  }

  // \pre image().common is not null
  constexpr CommonPart common() const {
    return parse_common_part(overridden(*image_.common, EdsPart::common, 0));
  }
  // \pre image().profiles[channel] is not null
  constexpr Bp3Part bp3(std::size_t channel) const {
    return parse_bp3_part(overridden(*image_.profiles[channel], EdsPart::bp3, channel));
  }

 private:
  constexpr const EdsBank* bank_of(const EdsOverride& each) const {
    if (each.part == EdsPart::common) return image_.common;
    if (each.channel >= max_channels) return nullptr;
    return image_.profiles[each.channel];
  }

  constexpr EdsBank overridden(EdsBank bank, EdsPart part, std::size_t channel) const {
    for (const EdsOverride& each : overrides_) {
      if (each.part != part || (part == EdsPart::bp3 && each.channel != channel)) continue;
      const EdsField* field = find_field(fields_of(part), each.symbol);
      // announce() has refused what cannot be set.
      if (field != nullptr) static_cast<void>(set_field(bank, *field, each.value));
    }
    return bank;
  }

  const EdsImage& image_;
  std::span<const EdsOverride> overrides_;
};

}  // namespace biss::eds_detail
