#include "capture/sample_layout.hpp"

#include <algorithm>
#include <cstdint>

namespace biss::capture {

const char* fault_of(const RawLayout& layout) {
  if (layout.rate.count == 0) return "a sample rate of 1 Hz or more";
  if (layout.unit_bytes == 0 || layout.unit_bytes > max_unit_bytes) {
    return "samples of 1 to 8 bytes";
  }
  if (layout.lines.empty()) return "the bit of at least one line";
  std::uint64_t taken = 0;
  for (const SampleLine& line : layout.lines) {
    if (line.bit >= 8 * layout.unit_bytes) return "bits that lie in the sample, counted from 0";
    const std::uint64_t bit = std::uint64_t{1} << line.bit;
    if ((taken & bit) != 0) return "a bit of its own for each line";
    taken |= bit;
  }
  return nullptr;
}

RawLayout packed_layout(const std::vector<std::string>& lines, Hertz rate) {
  RawLayout layout{rate, std::max<std::size_t>(1, (lines.size() + 7) / 8), {}};
  for (std::size_t line = 0; line < lines.size(); ++line) {
    layout.lines.push_back({lines[line], static_cast<unsigned>(line)});
  }
  return layout;
}

}  // namespace biss::capture
