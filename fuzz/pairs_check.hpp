// The changes of two lines that a capture delivers are those that its edges say.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"
#include "fuzz/require.hpp"

namespace biss::fuzz {

/// The changes of one line: time and level, unknown ones too.
class LineStory {
 public:
  void put(std::int64_t time, wire::Level level) {
    if (!changes_.empty() && changes_.back().second == level) return;
    require(changes_.empty() || changes_.back().first <= time);
    changes_.emplace_back(time, level);
  }
  void put(const capture::LineChanges& changes) {
    bool high = changes.first_high;
    for (const std::int64_t time : changes.times) {
      put(time, high ? wire::Level::high : wire::Level::low);
      high = !high;
    }
  }
  bool operator==(const LineStory&) const = default;

 private:
  std::vector<std::pair<std::int64_t, wire::Level>> changes_;
};

/// What a capture says of two lines, and how it ends.
struct PairStory {
  LineStory ma;
  LineStory slo;
  Picoseconds end{};
  std::optional<capture::CaptureError> error;

  void put(std::span<const wire::Edge> edges, wire::LineIndex ma_line, wire::LineIndex slo_line) {
    for (const wire::Edge& edge : edges) {
      if (edge.line == ma_line) ma.put(edge.time.count, edge.level);
      if (edge.line == slo_line) slo.put(edge.time.count, edge.level);
    }
  }
};

inline PairStory story_of_edges(capture::EdgeSource& source, wire::LineIndex ma,
                                wire::LineIndex slo) {
  PairStory story;
  for (auto block = source.next_block();; block = source.next_block()) {
    if (!block.ok()) story.error = block.error();
    if (!block.ok() || block->empty()) break;
    story.put(*block, ma, slo);
  }
  story.end = source.end_time();
  return story;
}

/// `blocks` blocks of edges, then pairs, two pieces at a time.
inline PairStory story_of_pairs(capture::EdgeSource& source, wire::LineIndex ma,
                                wire::LineIndex slo, std::uint64_t blocks) {
  PairStory story;
  for (; blocks != 0; --blocks) {
    const auto block = source.next_block();
    if (!block.ok() || block->empty()) break;
    story.put(*block, ma, slo);
  }
  const auto pairs = source.pairs(ma, slo);
  require(pairs != nullptr);
  const auto on_edges = [&](std::span<const wire::Edge> edges) { story.put(edges, ma, slo); };
  std::unique_ptr<capture::PairPiece> used;
  auto piece = pairs->fetch(nullptr);
  while (piece && !pairs->error()) {
    auto next = pairs->fetch(std::move(used));
    piece->expand();
    if (pairs->settle(*piece, on_edges)) {
      story.ma.put(piece->ma);
      story.slo.put(piece->slo);
    }
    used = std::exchange(piece, std::move(next));
  }
  story.end = pairs->end_time();
  story.error = pairs->error();
  return story;
}

inline bool same_text(const char* a, const char* b) {
  return std::string_view(a == nullptr ? "" : a) == (b == nullptr ? "" : b);
}

/// Reads a capture both ways; `open` opens it each time. Pairs of two lines that `number` selects.
template <class Open>
void check_pairs(Open open, std::uint64_t number) {
  const capture::Opened edges = open();
  if (!edges) return;
  const auto lines = static_cast<wire::LineIndex>((*edges)->lines().size());
  if (lines == 0) return;
  const auto ma = static_cast<wire::LineIndex>(number % lines);
  const auto slo = static_cast<wire::LineIndex>(number / 64 % lines);
  const PairStory wanted = story_of_edges(**edges, ma, slo);
  const capture::Opened again = open();
  require(again.has_value());
  const PairStory found = story_of_pairs(**again, ma, slo, number / 4'096 % 4);
  require(found.ma == wanted.ma);
  require(found.slo == wanted.slo);
  require(found.end == wanted.end);
  require(found.error.has_value() == wanted.error.has_value());
  if (!found.error) return;
  require(found.error->cause == wanted.error->cause);
  require(found.error->line == wanted.error->line && found.error->column == wanted.error->column);
  require(same_text(found.error->expected, wanted.error->expected));
  require(same_text(found.error->part, wanted.error->part));
  require(found.error->part_number == wanted.error->part_number);
}

}  // namespace biss::fuzz
