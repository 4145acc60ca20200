// Real encoders as data: the meaning of their bits, their behaviour in time, and what is uncertain.
//
//   constexpr CatalogueEntry encoder = catalogue_encoder("resolute-26");
//   using Codec = FixedCodec<encoder.frame_format()>;
//
// Firmware that does this stores nothing of the catalogue.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "biss/catalogue/drivers.hpp"
#include "biss/catalogue/entry.hpp"
#include "biss/catalogue/ic_haus.hpp"
#include "biss/catalogue/makers.hpp"
#include "biss/catalogue/renishaw.hpp"
#include "biss/frame/format_text.hpp"

namespace biss {

namespace catalogue_detail {

template <std::size_t... Sizes>
constexpr auto joined(const std::array<CatalogueEntry, Sizes>&... groups) {
  std::array<CatalogueEntry, (Sizes + ...)> all{};
  auto at = all.begin();
  ((at = std::copy(groups.begin(), groups.end(), at)), ...);
  return all;
}

}  // namespace catalogue_detail

/// All entries; no two have the same name.
inline constexpr auto catalogue =
    catalogue_detail::joined(renishaw_encoders, ic_haus_encoders, maker_encoders, driver_encoders);

/// The entry of that name, null when there is none. Names are compared exactly. The pointer keeps
/// the whole catalogue in the program; firmware uses catalogue_encoder().
constexpr const CatalogueEntry* find_encoder(std::string_view name) {
  for (const CatalogueEntry& entry : catalogue) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

namespace catalogue_detail {

// Never defined: the compiler names it if an encoder's name is wrong.
void the_catalogue_has_no_encoder_of_this_name();

}  // namespace catalogue_detail

/// The entry of that name at compile time. A name that is not in the catalogue stops the build.
consteval CatalogueEntry catalogue_encoder(std::string_view name) {
  // Not by find_encoder(): g++ -fsanitize=undefined refuses to compare its result with null.
  for (const CatalogueEntry& entry : catalogue) {
    if (entry.name == name) return entry;
  }
  catalogue_detail::the_catalogue_has_no_encoder_of_this_name();
  return {};
}

namespace catalogue_detail {

constexpr bool canonical(const CatalogueEntry& entry) {
  const auto format = parse_format(entry.format);
  return format.ok() && format_text(*format).view() == entry.format;
}

constexpr bool names_differ() {
  for (auto a = catalogue.begin(); a != catalogue.end(); ++a) {
    for (auto b = a + 1; b != catalogue.end(); ++b) {
      if (a->name == b->name) return false;
    }
  }
  return true;
}

static_assert(std::all_of(catalogue.begin(), catalogue.end(), canonical));
static_assert(names_differ());

}  // namespace catalogue_detail

}  // namespace biss
