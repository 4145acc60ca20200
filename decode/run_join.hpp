// The cycles that begin in one run of a capture and end in the next one: read quickly as well.
#pragma once

#include <algorithm>
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
  void push(const PairRun& run, std::span<const CleanCycle> clean) {
    if (clean.empty()) {
      flush();
      decoder_.push(run, clean);
      return;
    }
    RunPlace begin;
    if (waits()) {
      begin = clean.front().begin;
      push_waiting(run, begin);
    }
    const RunPlace end = clean.back().end;
    const bool keeps = run.ma.times.size() - end.ma <= most_waiting &&
                       run.slo.times.size() - end.slo <= most_waiting;
    decoder_.push(run, begin, keeps ? end : run.end(), clean);
    if (keeps) keep(run, end);
  }

  /// Edges outside of a run; waiting edges are pushed before them.
  void push(std::span<const wire::Edge> edges, const Lines& lines) {
    flush();
    decoder_.push(edges, lines);
  }

  /// Pushes the waiting edges: the next edges of the decoder are not a run, or there are none.
  void flush() {
    if (!waits()) return;
    const PairRun run = waiting();
    decoder_.push(run, first_waiting, run.end(), {});
    clear();
  }

 private:
  // More than this is not a cycle at the border of two runs.
  static constexpr std::size_t most_waiting = 2 * CleanScratch::max_edges;
  // The edges of the next request that the finder needs after a cycle.
  static constexpr std::size_t edges_ahead = 8;
  static constexpr RunPlace first_waiting{1, 1};

  // The end of a run. The first change was already pushed: the finder needs the level before it.
  struct Line {
    bool first_high = false;
    std::vector<std::int64_t> times;

    LineRun run() const { return {times, first_high}; }
    void take(const LineRun& run, std::size_t from) {
      first_high = run.level(from) == wire::Level::high;
      const auto rest = run.times.subspan(from);
      times.assign(rest.begin(), rest.end());
    }
    // The changes of the next run before `end`; the first one may repeat the level.
    void append(const LineRun& next, std::size_t end) {
      const std::size_t begin = next.level(0) == run().level(times.size() - 1) ? 1 : 0;
      if (begin >= end) return;
      const auto more = next.times.first(end).subspan(begin);
      times.insert(times.end(), more.begin(), more.end());
    }
  };

  bool waits() const { return !ma_.times.empty(); }
  PairRun waiting() const { return {ma_.run(), slo_.run()}; }

  void clear() {
    ma_.times.clear();
    slo_.times.clear();
  }

  // Pushes the waiting edges and the edges of the run before `until`, the place of its first clean
  // cycle.
  void push_waiting(const PairRun& run, RunPlace until) {
    if (until.ma > most_waiting || until.slo > most_waiting) {
      flush();
      decoder_.push(run, {}, until, {});
      return;
    }
    slo_.append(run.slo, until.slo);
    ma_.append(run.ma, until.ma);
    const RunPlace end = waiting().end();
    const auto ahead = run.ma.times.subspan(until.ma);
    ma_.times.insert(
        ma_.times.end(), ahead.begin(),
        ahead.begin() + static_cast<std::ptrdiff_t>(std::min(edges_ahead, ahead.size())));
    finder_.find(waiting(), clean_);
    while (!clean_.empty() && clean_.back().end.ma > end.ma) clean_.pop_back();
    decoder_.push(waiting(), first_waiting, end, clean_);
    clear();
  }

  void keep(const PairRun& run, RunPlace from) {
    ma_.take(run.ma, from.ma - 1);
    slo_.take(run.slo, from.slo - 1);
  }

  CleanCycleFinder finder_;
  Decoder& decoder_;
  Line ma_;
  Line slo_;
  std::vector<CleanCycle> clean_;
};

}  // namespace biss::decode
