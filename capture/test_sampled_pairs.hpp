// Reads a capture as changes of two lines, and compares with its edges.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "capture/pair_source.hpp"
#include "capture/test_capture.hpp"

namespace biss::capture::pairs_of_samples {

/// What a capture says of two lines.
struct PairRead {
  /// Times of changes; the first is that of the first known level, which it has.
  struct Line {
    std::optional<bool> first_high;
    std::vector<std::int64_t> times;
    bool operator==(const Line&) const = default;
  };
  Line ma;
  Line slo;
  Picoseconds end_time;
  std::optional<CaptureError> error;
};

/// Appends levels as a consumer of pairs takes them.
class LineReader {
 public:
  void put(std::int64_t time, bool high) {
    if (last_ == high) return;
    if (!last_) line_.first_high = high;
    last_ = high;
    line_.times.push_back(time);
  }
  void put(const LineChanges& changes) {
    bool high = changes.first_high;
    for (const std::int64_t time : changes.times) {
      put(time, high);
      high = !high;
    }
  }
  const PairRead::Line& line() const { return line_; }

 private:
  PairRead::Line line_;
  std::optional<bool> last_;
};

/// The lines of a capture read as edges.
inline PairRead pair_of(const Read& read, wire::LineIndex ma, wire::LineIndex slo) {
  LineReader ma_line;
  LineReader slo_line;
  for (const wire::Edge& edge : read.edges) {
    if (edge.line == ma) ma_line.put(edge.time.count, edge.level == wire::Level::high);
    if (edge.line == slo) slo_line.put(edge.time.count, edge.level == wire::Level::high);
  }
  return {ma_line.line(), slo_line.line(), read.end_time, read.error};
}

/// Reads `blocks` blocks as edges and the rest as pairs, with `in_flight` pieces between fetch() and
/// settle().
inline PairRead read_pairs(Opened opened, wire::LineIndex ma, wire::LineIndex slo,
                           std::size_t blocks = 0, std::size_t in_flight = 1) {
  PairRead read;
  if (!opened) {
    read.error = opened.error();
    return read;
  }
  LineReader ma_line;
  LineReader slo_line;
  const auto put_edges = [&](std::span<const wire::Edge> edges) {
    for (const wire::Edge& edge : edges) {
      if (edge.line == ma) ma_line.put(edge.time.count, edge.level == wire::Level::high);
      if (edge.line == slo) slo_line.put(edge.time.count, edge.level == wire::Level::high);
    }
  };
  for (std::size_t i = 0; i < blocks; ++i) {
    const auto block = (*opened)->next_block();
    if (!block.ok()) break;
    put_edges(*block);
  }
  const auto pairs = (*opened)->pairs(ma, slo);
  EXPECT_NE(pairs, nullptr);
  std::deque<std::unique_ptr<PairPiece>> pieces;
  std::unique_ptr<PairPiece> used;
  bool more = true;
  while (!pairs->error()) {
    while (more && pieces.size() < in_flight) {
      auto piece = pairs->fetch(std::move(used));
      more = piece != nullptr;
      if (!more) break;
      piece->expand();
      pieces.push_back(std::move(piece));
    }
    if (pieces.empty()) break;
    used = std::move(pieces.front());
    pieces.pop_front();
    if (!pairs->settle(*used, put_edges)) continue;
    ma_line.put(used->ma);
    slo_line.put(used->slo);
  }
  return {ma_line.line(), slo_line.line(), pairs->end_time(), pairs->error()};
}

inline bool same_error(const std::optional<CaptureError>& a, const std::optional<CaptureError>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return a->cause == b->cause && a->line == b->line && a->column == b->column &&
         std::string_view(a->expected == nullptr ? "" : a->expected) ==
             (b->expected == nullptr ? "" : b->expected) &&
         std::string_view(a->part == nullptr ? "" : a->part) ==
             (b->part == nullptr ? "" : b->part) &&
         a->part_number == b->part_number;
}

inline void expect_same(const PairRead& pairs, const PairRead& edges) {
  EXPECT_TRUE(pairs.ma == edges.ma) << pairs.ma.times.size() << ' ' << edges.ma.times.size();
  EXPECT_TRUE(pairs.slo == edges.slo) << pairs.slo.times.size() << ' ' << edges.slo.times.size();
  EXPECT_EQ(pairs.end_time, edges.end_time);
  EXPECT_TRUE(same_error(pairs.error, edges.error))
      << (pairs.error && pairs.error->expected != nullptr ? pairs.error->expected : "-") << " / "
      << (edges.error && edges.error->expected != nullptr ? edges.error->expected : "-");
}

}  // namespace biss::capture::pairs_of_samples
