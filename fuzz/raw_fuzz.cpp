// Raw samples of any layout: the reader has the same edges as a plain reader, or the layout is
// invalid.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/open.hpp"
#include "capture/samples.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/raw_header.hpp"
#include "fuzz/raw_mutator.hpp"
#include "fuzz/require.hpp"

namespace {

using biss::capture::RawLayout;
using biss::fuzz::require;

bool can_be(const RawLayout& layout) {
  std::vector<bool> used(256);
  for (const auto& line : layout.lines) {
    if (line.bit >= 8 * layout.unit_bytes || used[line.bit]) return false;
    used[line.bit] = true;
  }
  return layout.rate.count != 0 && layout.unit_bytes >= 1 && layout.unit_bytes <= 8 &&
         !layout.lines.empty();
}

bool is_high(std::string_view sample, unsigned bit) {
  return (static_cast<unsigned char>(sample[bit / 8]) >> (bit % 8) & 1) != 0;
}

// Reads sample by sample and bit by bit. Edges at the same time are in the order of the bits.
std::vector<biss::wire::Edge> plain_edges(const RawLayout& layout, std::string_view bytes) {
  using biss::wire::Level;
  const biss::capture::SampleClock clock(layout.rate);
  std::vector<std::pair<unsigned, biss::wire::LineIndex>> bits;
  for (std::size_t i = 0; i < layout.lines.size(); ++i) {
    bits.emplace_back(layout.lines[i].bit, static_cast<biss::wire::LineIndex>(i));
  }
  std::sort(bits.begin(), bits.end());
  std::vector<biss::wire::Edge> edges;
  std::string_view last;
  for (std::size_t i = 0; i < bytes.size() / layout.unit_bytes && i <= clock.last_index(); ++i) {
    const std::string_view sample = bytes.substr(i * layout.unit_bytes, layout.unit_bytes);
    if (sample == last) continue;
    for (const auto& [bit, line] : bits) {
      const bool high = is_high(sample, bit);
      if (!last.empty() && high == is_high(last, bit)) continue;
      edges.push_back({clock.time_of(i), line, high ? Level::high : Level::low});
    }
    last = sample;
  }
  return edges;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (size < biss::fuzz::raw_header_bytes) return 0;
  const RawLayout layout = biss::fuzz::raw_layout(input);
  const std::string_view samples = input.substr(biss::fuzz::raw_header_bytes);
  const auto read = biss::fuzz::check_reader(samples, [&](auto bytes) {
    return biss::capture::open_capture(std::move(bytes), "x.raw", {.raw = layout});
  });
  // A binary export of Saleae Logic is not raw samples, whatever its name.
  if (samples.starts_with("<SALEAE>")) return 0;
  require(read.lines.size() == (can_be(layout) ? layout.lines.size() : 0));
  if (can_be(layout)) require(read.edges == plain_edges(layout, samples));
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  return biss::fuzz::mutate_raw(data, size, max_size, seed);
}
