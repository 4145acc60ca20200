// Shared by the tests of sampled formats: random samples, a plain reading of them, archives.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/dsl.hpp"
#include "capture/samples.hpp"
#include "capture/sr.hpp"
#include "capture/test_capture.hpp"
#include "capture/zip.hpp"

namespace biss::capture {

/// Some of the bits of a sample in a random order, as lines `line0`, `line1`, …
inline RawLayout random_layout(std::mt19937_64& random, std::size_t unit_bytes, Hertz rate) {
  std::vector<unsigned> bits(8 * unit_bytes);
  for (std::size_t i = 0; i < bits.size(); ++i) bits[i] = static_cast<unsigned>(i);
  for (std::size_t i = bits.size(); i-- > 1;) std::swap(bits[i], bits[random() % (i + 1)]);
  bits.resize(1 + random() % bits.size());
  RawLayout layout{rate, unit_bytes, {}};
  for (const unsigned bit : bits) {
    layout.lines.push_back({"line" + std::to_string(layout.lines.size()), bit});
  }
  return layout;
}

/// Samples that rest for a while and then change in a few bits.
inline std::string random_samples(std::mt19937_64& random, std::size_t unit_bytes,
                                  std::size_t samples) {
  std::string bytes;
  std::uint64_t sample = random();
  std::size_t rest = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    if (rest-- == 0) {
      rest = random() % (random() % 4 == 0 ? 100 : 3);
      sample ^= std::uint64_t{1} << (random() % 64);
    }
    for (std::size_t k = 0; k < unit_bytes; ++k) bytes += static_cast<char>(sample >> (8 * k));
  }
  return bytes;
}

/// The edges of whole samples, found line by line and bit by bit. Edges with the same time are in
/// the order of their bits.
inline std::vector<wire::Edge> plain_edges(const RawLayout& layout, std::string_view bytes) {
  std::vector<wire::Edge> edges;
  std::vector<int> levels(layout.lines.size(), -1);
  std::vector<std::size_t> by_bit(levels.size());
  for (std::size_t line = 0; line < by_bit.size(); ++line) by_bit[line] = line;
  std::stable_sort(by_bit.begin(), by_bit.end(), [&](std::size_t a, std::size_t b) {
    return layout.lines[a].bit < layout.lines[b].bit;
  });
  const SampleClock clock(layout.rate);
  std::string_view before;
  const std::size_t samples = bytes.size() / layout.unit_bytes;
  for (std::size_t i = 0; i < samples && i <= clock.last_index(); ++i) {
    const std::string_view sample = bytes.substr(i * layout.unit_bytes, layout.unit_bytes);
    if (std::exchange(before, sample) == sample) continue;
    for (const std::size_t line : by_bit) {
      const unsigned bit = layout.lines[line].bit;
      const int level = static_cast<unsigned char>(sample[bit / 8]) >> (bit % 8) & 1;
      if (levels[line] == level) continue;
      levels[line] = level;
      edges.push_back({clock.time_of(i), static_cast<wire::LineIndex>(line),
                       level == 1 ? wire::Level::high : wire::Level::low});
    }
  }
  return edges;
}

inline Read read_raw(std::string_view bytes, const RawLayout& layout,
                     std::size_t block = one_block) {
  return read_all(open_raw(memory_bytes(bytes, block), layout));
}

inline Read read_sr(std::string_view bytes, std::size_t block = one_block) {
  return read_all(open_zip(memory_bytes(bytes, block)));
}

using Members = std::vector<std::pair<std::string, std::string>>;

inline std::string zip_of(const Members& members) {
  ZipWriter archive;
  std::string out;
  for (const auto& [name, text] : members) archive.add(name, text, out);
  archive.finish(out);
  return out;
}

/// A session of MA and SLO at 1 MHz in a byte a sample, its samples in these chunks.
inline Members session_of(const std::vector<std::string>& chunks) {
  Members members{{"version", "2"},
                  {"metadata",
                   "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\n"
                   "total probes=2\nsamplerate=1 MHz\nprobe1=MA\nprobe2=SLO\nunitsize=1\n"}};
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    members.emplace_back("logic-1-" + std::to_string(i + 1), chunks[i]);
  }
  return members;
}

}  // namespace biss::capture
