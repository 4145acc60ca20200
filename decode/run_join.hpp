// The cycles that begin in one run of a capture and end in the next one: read quickly as well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "decode/clean_cycles.hpp"
#include "decode/decoder.hpp"

namespace biss::decode {

/// Pushes runs into a decoder, in their order. The edges after the last clean cycle of a run wait
/// for the first clean cycle of the next run, and are searched for clean cycles together with the
/// edges before that one.
class RunJoin {
 public:
  RunJoin(const CleanCycleFinder& finder, Decoder& decoder) : finder_(finder), decoder_(decoder) {}

  /// \param clean the clean cycles of the run, in their order
  void push(const PairRun& run, std::span<const CleanCycle> clean);
  /// Edges outside of a run; waiting edges are pushed before them.
  void push(std::span<const wire::Edge> edges, const Lines& lines);
  /// Pushes the waiting edges: the next edges of the decoder are not a run, or there are none.
  void flush();

 private:
  // The end of a run. The first change was already pushed: the finder needs the level before it.
  struct Line {
    bool first_high = false;
    std::vector<std::int64_t> times;

    LineRun run() const { return {times, first_high}; }
    void take(const LineRun& run, std::size_t from);
    void append(const LineRun& run, std::size_t end);
  };

  bool waits() const { return !ma_.times.empty(); }
  PairRun waiting() const { return {ma_.run(), slo_.run()}; }
  void clear();
  void push_waiting(const PairRun& run, RunPlace until);
  void keep(const PairRun& run, RunPlace from);

  CleanCycleFinder finder_;
  Decoder& decoder_;
  Line ma_;
  Line slo_;
  std::vector<CleanCycle> clean_;
};

}  // namespace biss::decode
