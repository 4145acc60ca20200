// The block of edges that a reader fills between two calls of next_block().
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "wire/edge.hpp"

namespace biss::capture {

/// A line's last level as a number; `no_level` before its first edge.
inline constexpr std::uint8_t no_level = 3;

/// The edges of one block. Full long before it overflows: a row, a value or a sample may push one
/// edge a line.
class EdgeBlock {
 public:
  /// `lines` edges always fit behind the last one for which full() was false.
  void prepare(std::size_t lines) {
    count_ = 0;
    edges_.resize(limit_ + lines);
  }
  bool full() const { return count_ >= limit_; }
  bool empty() const { return count_ == 0; }
  void push(wire::Edge edge) { edges_[count_++] = edge; }
  std::span<const wire::Edge> edges() const { return std::span(edges_).first(count_); }
  /// Lets the next block be larger when this one was full.
  void grow() {
    if (full() && limit_ < max_limit) limit_ *= 2;
  }

 private:
  static constexpr std::size_t max_limit = 8'192;

  std::size_t limit_ = 128;
  std::size_t count_ = 0;
  std::vector<wire::Edge> edges_;
};

}  // namespace biss::capture
