// The invariants of every capture that a reader delivers, for any input.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/open.hpp"
#include "fuzz/cycles.hpp"
#include "fuzz/require.hpp"

namespace biss::fuzz {

/// A block size derived from the input, so that inputs stay plain captures.
inline std::size_t block_size_of(std::string_view text) {
  constexpr std::array<std::size_t, 8> sizes{1, 3, 7, 64, 500, 1'000, 4'096, 1'000'000};
  // Blocks of one byte cost the most and find no further errors in long text.
  constexpr std::size_t short_text = 512;
  constexpr std::size_t small_sizes = 3;
  std::size_t mixed = text.size();
  for (std::size_t i = 0; i < text.size(); i += 1 + text.size() / 8) {
    mixed = mixed * 31 + static_cast<unsigned char>(text[i]);
  }
  if (text.size() <= short_text) return sizes[mixed % sizes.size()];
  return sizes[small_sizes + mixed % (sizes.size() - small_sizes)];
}

/// The content of a capture up to its end or its first error.
struct Read {
  std::vector<std::string> lines;
  std::vector<wire::Edge> edges;
  Picoseconds end{};
};

/// Reads to the end. Reports a finding if times decrease, a line is not in the list, an edge
/// changes no level, an error has no text, or the end is not final.
inline Read read_checked(capture::Opened opened) {
  Read read;
  std::vector<wire::Edge>& all = read.edges;
  if (!opened) {
    require(!capture::capture_error_text(opened.error(), "x").empty());
    return read;
  }
  read.lines = (*opened)->lines();
  all.reserve(256);
  std::vector<int> levels(read.lines.size(), -1);
  for (;;) {
    const auto block = (*opened)->next_block();
    if (!block.ok() || block->empty()) {
      const auto again = (*opened)->next_block();
      require(again.ok() == block.ok() && (!again.ok() || again->empty()));
      require(block.ok() || !capture::capture_error_text(block.error(), "x").empty());
      break;
    }
    for (const wire::Edge& edge : *block) {
      require(edge.line < levels.size());
      require(all.empty() || edge.time >= all.back().time);
      require(levels[edge.line] != static_cast<int>(edge.level));
      levels[edge.line] = static_cast<int>(edge.level);
      all.push_back(edge);
    }
  }
  read.end = (*opened)->end_time();
  require(all.empty() || read.end >= all.back().time);
  return read;
}

/// Reads `text` in blocks of the size derived from it and, for short text, in one block too: the
/// edges must be the same. Then reads their request cycles. Returns the content.
template <class Open>
Read check_reader(std::string_view text, Open open) {
  Read read = read_checked(open(capture::memory_bytes(text, block_size_of(text))));
  check_cycles(read.lines, read.edges, read.end);
  constexpr std::size_t short_text = 512;
  if (text.size() <= short_text) {
    require(read.edges == read_checked(open(capture::memory_bytes(text))).edges);
  }
  return read;
}

}  // namespace biss::fuzz
