// A piece of a capture on its way to the decoder.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "capture/pair_source.hpp"
#include "decode/clean_cycles.hpp"
#include "decode/decoder.hpp"
#include "decode/run_join.hpp"

namespace biss::flow {

/// Functions that get each piece in the order of PairSource::settle(); they may be null.
struct Watch {
  /// Before the decoder gets the edges.
  capture::PairSource::OnEdges on_edges = nullptr;
  /// Called after the decoder got a regular piece.
  std::function<void(const capture::PairPiece& changes)> on_changes = nullptr;
};

/// A piece, with the memory for the search for clean cycles in it. fetch(), expand() and settle()
/// are called in this order; expand() by any thread.
class Piece {
 public:
  explicit Piece(const decode::CleanCycleFinder& like) : finder_(like) {}

  /// Replaces the piece by the next one of the source. False at the end.
  bool fetch(capture::PairSource& source);

  /// Expands the piece and finds its clean cycles. That many other pieces are expanded before this
  /// thread has the next one.
  void expand(const decode::Lines& lines, std::size_t others = 0);

  /// Pushes the piece into the decoder of `join`.
  void settle(capture::PairSource& source, const decode::Lines& lines, decode::RunJoin& join,
              const Watch& watch = {});

 private:
  decode::PairRun run_of(const decode::Lines& lines) const;

  std::unique_ptr<capture::PairPiece> piece_;
  decode::CleanCycleFinder finder_;
  std::vector<decode::CleanCycle> clean_;
};

}  // namespace biss::flow
