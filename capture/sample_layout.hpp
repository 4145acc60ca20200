// What the bytes of a sampled capture mean.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "biss/base/units.hpp"

namespace biss::capture {

/// A sample is a little-endian number of so many bytes at most: 64 lines.
inline constexpr std::size_t max_unit_bytes = 8;

/// A line and its bit in the sample; bit 0 is the lowest of the first byte.
struct SampleLine {
  std::string name;
  unsigned bit = 0;
};

/// Raw samples say nothing of themselves; this says it for them. Bits that no line names are not
/// looked at.
struct RawLayout {
  Hertz rate;
  std::size_t unit_bytes = 1;
  std::vector<SampleLine> lines;
};

/// What is wrong with a layout, as static text that says what would be right; null when nothing is.
const char* fault_of(const RawLayout& layout);

/// The lines in this order on bits 0, 1, …, in as few bytes as hold them.
RawLayout packed_layout(const std::vector<std::string>& lines, Hertz rate);

}  // namespace biss::capture
