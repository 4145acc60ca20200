// Edges of MA and SLO in, rows out: finds the request cycles in a stream of any length and any
// damage.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "decode/cycle_reader.hpp"
#include "wire/edge.hpp"

namespace biss::decode {

/// Which of a capture's lines are MA and SLO.
struct Lines {
  wire::LineIndex ma = 0;
  wire::LineIndex slo = 0;

  bool operator==(const Lines&) const = default;
};

/// Splits MA into request cycles and reads each.
///
/// A cycle begins with the first falling edge of MA after idle and ends where MA stays still for
/// more than 1.25 periods, measured on the spot: every cycle may have its own clock. A stillness of
/// up to 4 periods inside a frame that is not complete is taken for missing edges, not for the end.
/// Memory is bounded by the longest cycle, whatever the length of the capture.
class Decoder {
 public:
  using OnCycle = std::function<void(const Cycle&)>;

  Decoder(CycleReader reader, OnCycle on_cycle)
      : reader_(std::move(reader)), on_cycle_(std::move(on_cycle)) {}

  /// Changes in time order, MA and SLO mixed as they come.
  void push_ma(LevelChange change);
  void push_slo(LevelChange change) { slo_.push(change); }

  /// The same for a capture's edges; those of other lines are passed over.
  void push(std::span<const wire::Edge> edges, const Lines& lines);

  /// The capture ends at this time; reads what is left.
  void finish(Picoseconds end_time);

 private:
  // More edges than the longest frame (ACK and line delay included) are no request.
  static constexpr std::size_t max_cycle_edges = 2 * (max_frame_bits + 64);
  // So many edges ahead tell the clock of a cycle that begins.
  static constexpr std::size_t lookahead_edges = 12;

  void drain(bool at_end);
  bool drop_to_begin(bool at_end);
  bool take_cycle(bool at_end);
  void emit(std::size_t edges, Picoseconds limit, bool last_of_capture);
  Picoseconds half_period_ahead() const;
  CycleSpan span_of(std::size_t edges, Picoseconds limit, bool last_of_capture) const;

  CycleReader reader_;
  OnCycle on_cycle_;
  LineHistory slo_;
  std::vector<LevelChange> ma_;
  std::size_t scanned_ = 0;
  Picoseconds half_{};
  Picoseconds usual_half_{};
  Picoseconds begin_time_{};
  Picoseconds end_time_{};
  wire::Level ma_level_ = wire::Level::unknown;
  bool ma_seen_ = false;
  bool idle_known_ = false;
  bool swallowing_ = false;
};

}  // namespace biss::decode
