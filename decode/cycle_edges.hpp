// Request cycles with their edges: for code that needs the lines and not only the bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "decode/decoder.hpp"

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

/// The changes of a line that later cycles may need.
struct LineChanges {
  /// If there are more, the older half is dropped.
  std::size_t most = 0;
  std::vector<LevelChange> changes{};
  wire::Level before = wire::Level::unknown;

  void push(LevelChange change);
  void forget_before(Picoseconds time);
  /// Valid until the next push().
  std::span<const LevelChange> between(Picoseconds from, Picoseconds to) const;
};

/// Reads a cycle again from its edges.
/// \param slo_inverted take SLO as the inverse of the captured line
CycleReading read_again(const CycleEdges& edges, CycleReader& reader, bool slo_inverted = false);

/// Delivers each cycle of a capture with its edges, in order. Memory is bounded, for captures of
/// any length: if a line has more than `max_edges` in a cycle, the oldest are dropped.
class CycleEdgeReader {
 public:
  using OnCycle = std::function<void(const CycleEdges&)>;
  static constexpr std::size_t max_edges = std::size_t{1} << 15U;

  CycleEdgeReader(const CycleReader& reader, const Lines& lines, OnCycle on_cycle);
  // The decoder calls back into this object.
  CycleEdgeReader(const CycleEdgeReader&) = delete;
  CycleEdgeReader& operator=(const CycleEdgeReader&) = delete;

  /// Edges in time order; edges of other lines are ignored.
  void push(std::span<const wire::Edge> edges);
  /// The same as Decoder::finish().
  void finish(Picoseconds end_time);

 private:
  void take(const Cycle& cycle);
  void deliver(Picoseconds limit, bool last_of_capture);

  Lines lines_;
  OnCycle on_cycle_;
  LineChanges ma_{.most = max_edges};
  LineChanges slo_{.most = max_edges};
  // The cycle whose end is not known yet.
  std::optional<Cycle> waiting_;
  std::uint64_t number_ = 0;
  Decoder decoder_;
};

}  // namespace biss::decode
