// A capture's pieces through all cores: fetched one after the other, expanded and searched for clean
// cycles by any thread, decoded in their order.
#pragma once

#include <functional>

#include "flow/piece.hpp"

namespace biss::flow {

/// Reads a capture to its end, or to a read error, into a decoder, which it does not finish: step()
/// or run(), then flush(). The cycles are the same for any number of threads. Memory has a few
/// pieces for each thread.
class CycleFlow {
 public:
  /// \pre `source`, `decoder` and `watcher` outlive it
  CycleFlow(capture::PairSource& source, const decode::CleanCycleFinder& finder,
            const decode::Lines& lines, decode::Decoder& decoder, ChangeWatcher* watcher = nullptr)
      : source_(source),
        finder_(finder),
        lines_(lines),
        watcher_(watcher),
        piece_(finder),
        join_(finder, decoder) {}

  /// Reads the next piece in this thread. False at the end, and after a read error.
  bool step() {
    if (!piece_.fetch(source_)) return false;
    piece_.expand(lines_);
    return settle(piece_);
  }
  /// Reads all pieces.
  /// \param threads 0: one for each processor of the machine
  /// \param go_on called after each piece, unless it is null; false ends the reading
  void run(unsigned threads, const std::function<bool()>& go_on);
  /// Call it after the last piece.
  void flush() { join_.flush(); }

 private:
  class Workers;

  bool settle(Piece& piece) {
    piece.settle(source_, lines_, join_, watcher_);
    return !source_.error();
  }

  capture::PairSource& source_;
  decode::CleanCycleFinder finder_;
  decode::Lines lines_;
  ChangeWatcher* watcher_;
  Piece piece_;
  decode::RunJoin join_;
};

}  // namespace biss::flow
