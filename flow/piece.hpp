// A piece of a capture on its way to the decoder.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "capture/pair_source.hpp"
#include "decode/clean_cycles.hpp"
#include "decode/decoder.hpp"
#include "decode/run_join.hpp"

namespace biss::flow {

/// Sees the changes of a capture on their way to the decoder, each once and in order, in any thread.
class ChangeWatcher {
 public:
  virtual ~ChangeWatcher() = default;
  /// Edges of all lines, before the decoder gets them.
  virtual void take(std::span<const wire::Edge> edges) = 0;
  /// Changes of MA and SLO, as PairSource::settle() gives them, after the decoder got them.
  virtual void take(const capture::PairPiece& changes) = 0;
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

  /// Pushes the piece into the decoder of `join`. \param watcher may be null
  void settle(capture::PairSource& source, const decode::Lines& lines, decode::RunJoin& join,
              ChangeWatcher* watcher = nullptr);

 private:
  decode::PairRun run_of(const decode::Lines& lines) const;

  std::unique_ptr<capture::PairPiece> piece_;
  decode::CleanCycleFinder finder_;
  std::vector<decode::CleanCycle> clean_;
};

}  // namespace biss::flow
