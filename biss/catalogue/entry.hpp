// An entry of the catalogue.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "biss/frame/format.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Sentences that apply to several entries.
namespace doubt {
inline constexpr std::string_view driver = "known from a driver's source, not from the maker";
inline constexpr std::string_view clock = "the highest clock is not stated: 10 MHz assumed";
inline constexpr std::string_view timeout = "the timeout is not stated: the longest legal assumed";
inline constexpr std::string_view sampling_clock =
    "adaptive timeout: the encoder's sampling clock is not stated, 1.5 periods taken";
inline constexpr std::string_view polynomial =
    "the maker does not name the CRC polynomial: 0x43 assumed";
inline constexpr std::string_view flags =
    "the two flags are not stated: nE and nW before the CRC assumed";
inline constexpr std::string_view start = "the CRC's start value can be programmed: 0 assumed";
inline constexpr std::string_view start_unstated = "the CRC's start value is not stated: 0 assumed";
inline constexpr std::string_view start_and_inversion =
    "the CRC's start value and inversion are not stated: 0, inverted assumed";
inline constexpr std::string_view clock_configured =
    "the source configures 4 MHz, the limit is not known: 10 MHz assumed";
}  // namespace doubt

/// One type of encoder, with one frame. All text is static.
struct CatalogueEntry {
  /// The name that a user types, in lower case.
  std::string_view name{};
  std::string_view vendor{};
  std::string_view product{};
  /// Canonical text of the frame format; it parses (proven at compile time).
  std::string_view format{};
  DeviceTiming timing{};
  /// The size of one count, and the range if it is known; empty when unknown.
  std::string_view resolution{};
  /// Important facts for the user that no other field describes; empty if there are none.
  std::string_view remark{};
  /// The source of these facts.
  std::string_view source{};
  /// Facts that are assumed, deduced or not confirmed, one sentence each. Unused places at the end
  /// are empty.
  std::array<std::string_view, 5> uncertain{};

  /// The format as data. \pre format is good text
  constexpr FrameFormat frame_format() const { return parse_format(format).value(); }
  constexpr bool certain() const { return uncertain[0].empty(); }
  /// Whether this is one of the doubts.
  constexpr bool doubts(std::string_view sentence) const {
    for (const std::string_view each : uncertain) {
      if (each == sentence) return true;
    }
    return false;
  }
  /// The highest clock is a limit of the device, not only the highest that BiSS C allows.
  constexpr bool clock_known() const {
    return !doubts(doubt::clock) && !doubts(doubt::clock_configured);
  }

  /// A type of this family. An empty text means the same as in the family.
  constexpr CatalogueEntry type(std::string_view its_name, std::string_view its_format,
                                std::string_view its_resolution = {},
                                std::string_view its_product = {}) const {
    CatalogueEntry entry = *this;
    entry.name = its_name;
    entry.format = its_format;
    if (!its_resolution.empty()) entry.resolution = its_resolution;
    if (!its_product.empty()) entry.product = its_product;
    return entry;
  }
  constexpr CatalogueEntry with_remark(std::string_view its_remark) const {
    CatalogueEntry entry = *this;
    entry.remark = its_remark;
    return entry;
  }
  /// With one more doubt. \pre there is room
  constexpr CatalogueEntry with_doubt(std::string_view sentence) const {
    CatalogueEntry entry = *this;
    std::size_t free = 0;
    while (!entry.uncertain[free].empty()) ++free;
    entry.uncertain[free] = sentence;
    return entry;
  }
};

}  // namespace biss
