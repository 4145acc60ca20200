// Edges of MA and SLO in, rows out: finds the request cycles in a stream of any length and any
// damage.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
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
/// up to 4 periods is doubtful: it may as well be missing edges. It ends a cycle whose frame is
/// complete, that is as long as the one before, or behind which stands a frame with a checksum that
/// is right, as long as what is before it or shorter.
///
/// Memory is bounded by the longest cycle, whatever the length of the capture.
class Decoder {
 public:
  using OnCycle = std::function<void(const Cycle&)>;

  Decoder(CycleReader reader, OnCycle on_cycle)
      : reader_(std::move(reader)), on_cycle_(std::move(on_cycle)) {}

  /// Changes in time order, MA and SLO mixed as they come. The first change of a line gives its
  /// initial level.
  void push_ma(LevelChange change);
  void push_slo(LevelChange change);

  /// The same for a capture's edges; those of other lines are passed over.
  void push(std::span<const wire::Edge> edges, const Lines& lines);

  /// The capture ends at this time, which is not before its last edge; reads what is left.
  void finish(Picoseconds end_time);

 private:
  // More edges than the longest frame (ACK and line delay included) are no request.
  static constexpr std::size_t max_cycle_edges = 2 * (max_frame_bits + 64);
  // So many edges ahead tell the clock of a cycle that begins.
  static constexpr std::size_t lookahead_edges = 12;
  // So many edges in less than half their time are a faster clock than what the cycle began with.
  static constexpr std::size_t faster_clock_edges = 24;
  static constexpr std::size_t faster_clock_step = 8;

  void drain(bool at_end);
  bool find_begin(bool at_end);
  bool take_cycle(bool at_end);
  CycleReading read_front(Picoseconds next, bool last_of_capture);
  CycleReading read(std::size_t begin, Picoseconds next, bool last_of_capture);
  bool is_over(const CycleReading& reading) const;
  bool repeats(const CycleReading& reading);
  bool frame_behind_doubt(Picoseconds next, bool last_of_capture);
  void pass_over(Picoseconds time);
  void follow_clock(Picoseconds begin, Picoseconds end);
  void emit(const CycleReading& reading);
  void give_up();
  void drop_return_to_idle();
  bool is_doubted() const { return doubt_ != 0 && doubt_ != scanned_; }
  bool is_long_still(Picoseconds still) const { return 4 * still > 5 * period_; }
  Picoseconds period_ahead() const;
  std::int64_t clocks_between(std::size_t first, std::size_t end, Picoseconds period) const;

  CycleReader reader_;
  OnCycle on_cycle_;
  LineHistory slo_;
  // From the first edge of the cycle that is looked at; edges before scanned_ belong to it.
  std::vector<LevelChange> ma_;
  std::size_t scanned_ = 0;
  // Index of the first edge behind the last doubtful stillness, 0 when there was none.
  std::size_t doubt_ = 0;
  Picoseconds period_{};
  // Length of the cycle before, 0 when there was none that tells.
  std::int64_t usual_clocks_ = 0;
  Picoseconds begin_time_{};
  Picoseconds end_time_{};
  wire::Level ma_level_ = wire::Level::unknown;
  bool idle_known_ = false;
  // MA ran on for longer than any request; what follows until it is still is passed over.
  bool passing_over_ = false;
  Picoseconds passed_over_{};
  // Every so many edges passed over.
  Picoseconds passed_mark_{};
  std::size_t passed_edges_ = 0;
};

}  // namespace biss::decode
