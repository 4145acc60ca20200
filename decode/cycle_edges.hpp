// Request cycles with their edges: for code that needs the lines and not only the bits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "decode/cycle_rules.hpp"
#include "decode/decoder.hpp"
#include "decode/times.hpp"

namespace biss::decode {

/// A request cycle and the changes of both lines from its beginning to the next one. Valid during
/// the call that delivers it.
struct CycleEdges {
  const Cycle& cycle;
  /// Counted from 0, as the rows of `decode`.
  std::uint64_t number = 0;
  /// From the first falling edge of MA to its last one.
  std::span<const LevelChange> ma;
  /// The changes of MA after that: its return to idle, and pulses.
  std::span<const LevelChange> ma_after;
  wire::Level slo_before = wire::Level::unknown;
  /// From the first falling edge of MA to `limit`.
  std::span<const LevelChange> slo;
  /// The next request, or the end of the capture; also if there are too many edges in between to
  /// keep them.
  Picoseconds limit{};
  bool last_of_capture = false;
};

/// The cycle with its edges. \param limit, last_of_capture as in CycleEdges
inline CycleEdges edges_of(const Cycle& cycle, std::uint64_t number, const LineHistory& ma,
                           const LineHistory& slo, Picoseconds limit, bool last_of_capture) {
  const Picoseconds after = shifted(shifted(cycle.time, cycle.clocked), picoseconds(1));
  return {.cycle = cycle,
          .number = number,
          .ma = ma.between(cycle.time, after),
          .ma_after = ma.between(after, limit),
          .slo_before = slo.level_before(slo.from(cycle.time)),
          .slo = slo.between(cycle.time, limit),
          .limit = limit,
          .last_of_capture = last_of_capture};
}

/// Reads a cycle again from its edges.
/// \param slo_inverted take SLO as the inverse of the captured line
inline CycleReading read_again(const CycleEdges& edges, CycleReader& reader,
                               bool slo_inverted = false) {
  LineHistory slo;
  slo.push({shifted(edges.cycle.time, -picoseconds(1)), seen_as(edges.slo_before, slo_inverted)});
  for (const LevelChange& change : edges.slo) {
    slo.push({change.time, seen_as(change.level, slo_inverted)});
  }
  const Picoseconds last = edges.ma.empty() ? edges.cycle.time : edges.ma.back().time;
  const LevelChange nothing{edges.cycle.time, wire::Level::low};
  return reader.read({.ma = edges.ma.empty() ? std::span<const LevelChange>(&nothing, 1) : edges.ma,
                      .begins_idle = edges.cycle.status != CycleStatus::cut_start,
                      .limit = std::min(edges.limit, shifted(last, slo_matters)),
                      .last_of_capture = edges.last_of_capture,
                      .usual_clocks = edges.cycle.pauses == 0 ? SIZE_MAX : 0},
                     slo);
}

/// Delivers each cycle of a capture with its edges, in order. Memory is bounded, for captures of
/// any length: if a line has more than `max_edges` in a cycle, the oldest are dropped.
class CycleEdgeReader {
 public:
  using OnCycle = std::function<void(const CycleEdges&)>;
  static constexpr std::size_t max_edges = std::size_t{1} << 15U;

  CycleEdgeReader(const CycleReader& reader, const Lines& lines, OnCycle on_cycle)
      : lines_(lines),
        on_cycle_(std::move(on_cycle)),
        decoder_(reader, [this](const Cycle& cycle) { take(cycle); }) {}

  // The decoder calls back into this object.
  CycleEdgeReader(const CycleEdgeReader&) = delete;
  CycleEdgeReader& operator=(const CycleEdgeReader&) = delete;

  /// Edges in time order; edges of other lines are ignored.
  void push(std::span<const wire::Edge> edges) {
    // In pieces, so that few edges are kept ahead of the decoder.
    constexpr std::size_t piece = 1024;
    while (!edges.empty()) {
      const auto now = edges.first(std::min(piece, edges.size()));
      for (const wire::Edge& edge : now) {
        if (edge.line == lines_.ma) {
          ma_.push_recent({edge.time, seen_as(edge.level, lines_.ma_inverted)}, max_edges);
        } else if (edge.line == lines_.slo) {
          slo_.push_recent({edge.time, seen_as(edge.level, lines_.slo_inverted)}, max_edges);
        }
      }
      decoder_.push(now, lines_);
      edges = edges.subspan(now.size());
    }
  }

  /// The same as Decoder::finish().
  void finish(Picoseconds end_time) {
    decoder_.finish(end_time);
    if (waiting_) deliver(std::max(end_time, waiting_->time), true);
    waiting_.reset();
  }

 private:
  void take(const Cycle& cycle) {
    if (waiting_) deliver(cycle.time, false);
    waiting_ = cycle;
    ma_.forget(ma_.from(cycle.time));
    slo_.forget(slo_.from(cycle.time));
  }

  void deliver(Picoseconds limit, bool last_of_capture) {
    on_cycle_(edges_of(*waiting_, number_++, ma_, slo_, limit, last_of_capture));
  }

  Lines lines_;
  OnCycle on_cycle_;
  LineHistory ma_;
  LineHistory slo_;
  // The cycle whose end is not known yet.
  std::optional<Cycle> waiting_;
  std::uint64_t number_ = 0;
  Decoder decoder_;
};

}  // namespace biss::decode
