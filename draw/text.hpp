// A drawing as text, for a terminal.
#pragma once

#include <cstddef>
#include <string>

#include "draw/cycle_drawing.hpp"

namespace biss::draw {

/// The lines of a cycle, in blocks that follow one another where it is wider than `columns`:
///
///     MA     ──┐  ┌──┐  ┌──
///              └──┘  └──┘
///     SLO    ──────────┐
///                      └───
///     sample      ▲     ▲
///     bit         1     0
///     field      LAT   ACK
///
/// Below a bit of the CRC that is wrong stands what it should be. UTF-8.
/// \param columns at least 60
std::string drawing_text(const CycleDrawing& drawing, std::size_t columns = 80);

}  // namespace biss::draw
