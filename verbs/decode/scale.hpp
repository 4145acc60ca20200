// `decode --scale`: the size of a count.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "biss/catalogue/entry.hpp"
#include "biss/frame/format.hpp"
#include "rows/motion.hpp"

namespace biss::verbs {

/// The size of a count of channel 1, as the catalogue states it; empty if it states none, or
/// several of which one is right.
std::optional<rows::Scale> scale_of(const CatalogueEntry& entry);

/// The unit of a value of `--scale`: `deg`, `mm`, `N/turn`, `2^N/turn`, or a length such as `50nm`
/// (nm, um, mm).
/// \return `deg` or `mm`; empty for any other text
std::optional<std::string> scale_unit(std::string_view text);

/// The scale for a value of `--scale`. `deg` takes the counts of a turn from the singleturn bits of
/// the format or from the catalogue, `mm` takes the size of a count from the catalogue.
/// \param entry null if the format has no name of the catalogue
/// \return one line if the scale is unknown
/// \pre scale_unit(text)
tl::expected<rows::Scale, std::string> choose_scale(std::string_view text,
                                                    const ChannelFormat& channel,
                                                    const CatalogueEntry* entry);

}  // namespace biss::verbs
