// Drawings as an SVG image, for a document.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "draw/layout.hpp"

namespace biss::draw {

/// A cycle of an image, and the line above it.
struct Panel {
  std::string title;
  Layout layout;
};

inline constexpr std::size_t svg_width_min = 480;
inline constexpr std::size_t svg_width_max = 4000;
inline constexpr std::size_t svg_width_usual = 960;

/// One image with all panels, one below the other. It contains no script, no external font and no
/// other file; it is readable on a light and on a dark page, and has a title and a description in
/// words. The same panels give the same bytes.
/// \param width in pixels, svg_width_min to svg_width_max
std::string svg_text(std::span<const Panel> panels, std::size_t width = svg_width_usual);

/// Text as written in an element or in the value of an attribute, of SVG and of HTML.
std::string markup_text(std::string_view text);

}  // namespace biss::draw
