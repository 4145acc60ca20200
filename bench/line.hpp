// A simulated line as edges and as captures, for what reads them: 26 bits at 10 MHz.
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

/// The line as a file's text; empty when that failed.
std::string vcd_text(const Line& line);
std::string csv_text(const Line& line);

}  // namespace biss::bench
