// A simulated line of 26 bits at 10 MHz, as edges and as captures.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "wire/edge.hpp"

namespace biss::bench {

inline constexpr const char* line_format_text = "pos26,nE,nW,crc6";

struct Line {
  FrameFormat format;
  std::size_t cycles = 0;
  std::vector<wire::Edge> edges;
  Picoseconds end{};
};

/// Random positions, no faults.
Line make_line(std::size_t cycles);

/// The line as the text of a capture file; empty after an error.
std::string vcd_text(const Line& line);
std::string csv_text(const Line& line);

}  // namespace biss::bench
