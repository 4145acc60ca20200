#include "decode/cycle_edges.hpp"

#include <algorithm>

#include "decode/cycle_rules.hpp"
#include "decode/times.hpp"

namespace biss::decode {

namespace {

using wire::Level;

bool is_earlier(const LevelChange& change, Picoseconds time) { return change.time < time; }

}  // namespace

CycleReading read_again(const CycleEdges& edges, CycleReader& reader, bool slo_inverted) {
  LineHistory slo;
  slo.push({shifted(edges.cycle.time, -picoseconds(1)), seen_as(edges.slo_before, slo_inverted)});
  for (const LevelChange& change : edges.slo) {
    slo.push({change.time, seen_as(change.level, slo_inverted)});
  }
  const Picoseconds last = edges.ma.empty() ? edges.cycle.time : edges.ma.back().time;
  const LevelChange nothing{edges.cycle.time, Level::low};
  return reader.read({.ma = edges.ma.empty() ? std::span<const LevelChange>(&nothing, 1) : edges.ma,
                      .begins_idle = edges.cycle.status != CycleStatus::cut_start,
                      .limit = std::min(edges.limit, shifted(last, slo_matters)),
                      .last_of_capture = edges.last_of_capture,
                      .usual_clocks = edges.cycle.pauses == 0 ? SIZE_MAX : 0},
                     slo);
}

CycleEdgeReader::CycleEdgeReader(const CycleReader& reader, const Lines& lines, OnCycle on_cycle)
    : lines_(lines),
      on_cycle_(std::move(on_cycle)),
      decoder_(reader, [this](const Cycle& cycle) { take(cycle); }) {}

void CycleEdgeReader::push(std::span<const wire::Edge> edges) {
  // In pieces, so that few edges are kept ahead of the decoder.
  constexpr std::size_t piece = 1024;
  while (!edges.empty()) {
    const auto now = edges.first(std::min(piece, edges.size()));
    for (const wire::Edge& edge : now) {
      if (edge.line == lines_.ma) {
        ma_.push({edge.time, seen_as(edge.level, lines_.ma_inverted)});
      } else if (edge.line == lines_.slo) {
        slo_.push({edge.time, seen_as(edge.level, lines_.slo_inverted)});
      }
    }
    decoder_.push(now, lines_);
    edges = edges.subspan(now.size());
  }
}

void CycleEdgeReader::finish(Picoseconds end_time) {
  decoder_.finish(end_time);
  if (waiting_) deliver(std::max(end_time, waiting_->time), true);
  waiting_.reset();
}

void CycleEdgeReader::take(const Cycle& cycle) {
  if (waiting_) deliver(cycle.time, false);
  waiting_ = cycle;
  ma_.forget_before(cycle.time);
  slo_.forget_before(cycle.time);
}

void CycleEdgeReader::deliver(Picoseconds limit, bool last_of_capture) {
  const Cycle& cycle = *waiting_;
  const Picoseconds last = shifted(cycle.time, cycle.clocked);
  const Picoseconds after = shifted(last, picoseconds(1));
  on_cycle_({.cycle = cycle,
             .number = number_++,
             .ma = ma_.between(cycle.time, after),
             .ma_after = ma_.between(after, limit),
             .slo_before = slo_.before,
             .slo = slo_.between(cycle.time, limit),
             .limit = limit,
             .last_of_capture = last_of_capture});
}

void LineChanges::push(LevelChange change) {
  if ((changes.empty() ? before : changes.back().level) == change.level) return;
  if (changes.size() >= most) {
    const std::size_t gone = most / 2;
    before = changes[gone - 1].level;
    changes.erase(changes.begin(), changes.begin() + static_cast<std::ptrdiff_t>(gone));
  }
  changes.push_back(change);
}

void LineChanges::forget_before(Picoseconds time) {
  const auto end = std::lower_bound(changes.begin(), changes.end(), time, is_earlier);
  if (end == changes.begin()) return;
  before = (end - 1)->level;
  changes.erase(changes.begin(), end);
}

std::span<const LevelChange> LineChanges::between(Picoseconds from, Picoseconds to) const {
  const auto first = std::lower_bound(changes.begin(), changes.end(), from, is_earlier);
  const auto last = std::lower_bound(first, changes.end(), to, is_earlier);
  return std::span<const LevelChange>(changes).subspan(
      static_cast<std::size_t>(first - changes.begin()), static_cast<std::size_t>(last - first));
}

}  // namespace biss::decode
