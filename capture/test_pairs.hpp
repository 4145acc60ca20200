// Shared by tests of PairSource: reads a capture by pairs(), and compares it with next_block().
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"
#include "capture/text_source.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// The changes of two lines, each in its own list.
struct PairRead {
  using Change = std::pair<std::int64_t, wire::Level>;

  std::array<std::vector<Change>, 2> changes;
  Picoseconds end_time;
  std::optional<CaptureError> error;
  bool by_pieces = false;     ///< pairs() returned a source
  std::size_t whole = 0;      ///< pieces of whole words or rows of a text
  std::size_t regular = 0;    ///< pieces that settle() took as arrays
  std::size_t largest = 0;    ///< the most bytes of a piece's memory for text
  bool edges_repeat = false;  ///< an edge that was delivered left its line as it was
  bool goes_back = false;     ///< a change is before the one before it

  void add(std::size_t line, std::int64_t time, wire::Level level) {
    auto& list = changes[line];
    if (!list.empty() && list.back().second == level) return;
    goes_back = goes_back || (!list.empty() && list.back().first > time);
    list.emplace_back(time, level);
  }
  void add(std::size_t line, const LineChanges& piece) {
    bool high = piece.first_high;
    for (const std::int64_t time : piece.times) {
      add(line, time, std::exchange(high, !high) ? wire::Level::high : wire::Level::low);
    }
  }
  void add(const wire::Edge& edge, wire::LineIndex ma, wire::LineIndex slo) {
    if (edge.line != ma && edge.line != slo) return;
    const std::size_t before = changes[0].size() + changes[1].size();
    if (edge.line == ma) add(0, edge.time.count, edge.level);
    if (edge.line == slo) add(1, edge.time.count, edge.level);
    edges_repeat = edges_repeat || changes[0].size() + changes[1].size() == before;
  }
};

/// How a capture is read: blocks of edges first, then by pieces, some of them ahead.
struct PairWay {
  wire::LineIndex ma = 0;
  wire::LineIndex slo = 1;
  std::size_t blocks = 0;
  std::size_t ahead = 3;
};

/// Fetches the pieces ahead, expands the last fetched first, settles the first fetched first.
inline void read_pieces(PairSource& source, const PairWay& way, PairRead& read) {
  const auto take = [&](std::span<const wire::Edge> edges) {
    for (const wire::Edge& edge : edges) read.add(edge, way.ma, way.slo);
  };
  std::deque<std::unique_ptr<PairPiece>> pieces;
  std::unique_ptr<PairPiece> used;
  std::size_t expanded = 0;
  for (bool ended = false;;) {
    while (!ended && pieces.size() < way.ahead) {
      auto piece = source.fetch(std::move(used));
      ended = !piece;
      if (piece) pieces.push_back(std::move(piece));
    }
    if (pieces.empty() || read.error) return;
    for (std::size_t i = pieces.size(); i > expanded; --i) pieces[i - 1]->expand();
    expanded = pieces.size() - 1;
    if (const auto* text = dynamic_cast<TextPiece*>(pieces.front().get())) {
      read.whole += text->part == TextPiece::Part::whole ? 1U : 0U;
      read.largest = std::max(read.largest, text->buffer.size());
    }
    if (source.settle(*pieces.front(), take)) {
      ++read.regular;
      read.add(0, pieces.front()->ma);
      read.add(1, pieces.front()->slo);
    }
    read.end_time = source.end_time();
    read.error = source.error();
    used = std::move(pieces.front());
    pieces.pop_front();
  }
}

inline PairRead read_pairs(const Opened& opened, const PairWay& way) {
  PairRead read;
  if (!opened) {
    read.error = opened.error();
    return read;
  }
  EdgeSource& source = **opened;
  for (std::size_t i = 0; i < way.blocks; ++i) {
    const auto block = source.next_block();
    if (!block.ok() || block->empty()) break;
    for (const wire::Edge& edge : *block) read.add(edge, way.ma, way.slo);
  }
  read.end_time = source.end_time();
  const auto pairs = source.pairs(way.ma, way.slo);
  read.by_pieces = pairs != nullptr;
  if (!pairs) return read;
  read.error = pairs->error();
  read_pieces(*pairs, way, read);
  return read;
}

/// The changes of the two lines of `way`, from the edges of next_block().
/// \param read has `edges`, `end_time` and `error`
template <class Read>
PairRead pairs_of_edges(const Read& read, const PairWay& way) {
  PairRead pairs;
  for (const wire::Edge& edge : read.edges) pairs.add(edge, way.ma, way.slo);
  pairs.end_time = read.end_time;
  pairs.error = read.error;
  return pairs;
}

/// The difference between the edges of next_block() and the changes of pairs(); empty if there is
/// none.
inline std::string difference(const PairRead& edges, const PairRead& pairs) {
  if (edges.changes[0] != pairs.changes[0]) return "changes of MA";
  if (edges.changes[1] != pairs.changes[1]) return "changes of SLO";
  if (pairs.edges_repeat) return "edges that change nothing";
  if (pairs.goes_back) return "changes in the order of time";
  if (edges.error.has_value() != pairs.error.has_value()) return "whether there is an error";
  if (edges.end_time != pairs.end_time) return "end time";
  if (!edges.error) return {};
  const CaptureError& wanted = *edges.error;
  const CaptureError& found = *pairs.error;
  const auto text = [](const char* words) { return std::string_view(words ? words : ""); };
  if (wanted.cause != found.cause) return "cause of the error";
  if (wanted.line != found.line || wanted.column != found.column) return "place of the error";
  if (text(wanted.expected) != text(found.expected)) return "text of the error";
  if (text(wanted.part) != text(found.part) || wanted.part_number != found.part_number) {
    return "part of the error";
  }
  return {};
}

}  // namespace biss::capture
