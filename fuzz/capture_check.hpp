// The invariants of every capture that a reader delivers, for any input.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
#include "capture/open.hpp"
#include "fuzz/cycles.hpp"
#include "fuzz/require.hpp"

namespace biss::fuzz {

/// A number that follows from the input, so that inputs stay plain captures.
inline std::size_t mixed_from(std::string_view text) {
  std::size_t mixed = text.size();
  for (std::size_t i = 0; i < text.size(); i += 1 + text.size() / 8) {
    mixed = mixed * 31 + static_cast<unsigned char>(text[i]);
  }
  return mixed ^ mixed >> 16U;
}

/// The size of the blocks that an input is read in. Blocks of a few bytes cost the most, and
/// the other sizes find most of what they find.
inline std::size_t block_size_of(std::string_view text) {
  constexpr std::array<std::size_t, 16> sizes{
      1, 3, 7, 64, 64, 500, 500, 1'000, 1'000, 4'096, 4'096, 4'096, 4'096, 4'096, 4'096, 1'000'000};
  return sizes[mixed_from(text) % sizes.size()];
}

/// Whether the input is read in one block too, to compare: the half of those in blocks of a few
/// bytes, and an eighth of the rest.
inline bool is_compared(std::string_view text) {
  constexpr std::size_t few_bytes = 64;
  const std::size_t parts = block_size_of(text) <= few_bytes ? 2 : 8;
  return mixed_from(text) / 16 % parts == 0;
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

/// Reads `input` in blocks of the size derived from it and, for a part of the inputs, in one block
/// too: the edges must be the same. Then reads their request cycles. Returns the content.
/// \param open opens the input, to be read in blocks of a size
template <class Open>
Read check_blocks(std::string_view input, Open open) {
  Read read = read_checked(open(block_size_of(input)));
  check_cycles(read.lines, read.edges, read.end);
  if (is_compared(input)) {
    require(read.edges == read_checked(open(std::numeric_limits<std::size_t>::max())).edges);
  }
  return read;
}

/// The same with `open` for the bytes of a file.
template <class Open>
Read check_reader(std::string_view text, Open open) {
  return check_blocks(text,
                      [&](std::size_t block) { return open(capture::memory_bytes(text, block)); });
}

}  // namespace biss::fuzz
