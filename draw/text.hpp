// A drawing as text, for a terminal or a document.
#pragma once

#include <cstddef>
#include <string>

#include "draw/layout.hpp"

namespace biss::draw {

/// The lines of a cycle, in blocks that follow one another if it is wider than `columns`:
///
///     MA     ──┐  ┌──┐  ┌──
///              └──┘  └──┘
///     SLO    ──────────┐
///                      └───
///     sample      ▲     ▲
///     bit         1     0
///     field      LAT   ACK
///
/// The line below a wrong bit of the CRC has its correct value. UTF-8.
/// \param columns at least 60
std::string drawing_text(const CycleDrawing& drawing, std::size_t columns = 80);

/// The same with the parts of the cycle by name and value below the bits, with cuts (`…`), and with
/// marks at failures:
///
///     frame    │request    │ACK 1 us, 1 clock │START│CDS=0│      pos=181     …
///     delay                 │line delay 50 ns
///     failure                                    ▲ crc: received 0x36, expected 0x1
std::string layout_text(const Layout& layout, std::size_t columns = 80);

}  // namespace biss::draw
