// Edges of MA and SLO in, rows out: finds the request cycles in a stream of any length and any
// damage.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "decode/clean_cycles.hpp"
#include "decode/cycle_reader.hpp"
#include "wire/edge.hpp"

namespace biss::decode {

/// Which of a capture's lines are MA and SLO.
struct Lines {
  wire::LineIndex ma = 0;
  wire::LineIndex slo = 0;
  /// The capture shows the inverse of the line.
  bool ma_inverted = false;
  bool slo_inverted = false;

  bool operator==(const Lines&) const = default;
};

/// Splits MA into request cycles and reads each.
///
/// A cycle begins with the first falling edge of MA after an idle gap and ends when no edge of MA
/// follows for more than 1.25 periods. The period is measured in the cycle: every cycle may have
/// its own clock. A gap of up to 4 periods is doubtful, because edges may be missing. It ends a
/// cycle whose frame is complete, a cycle that is as long as the previous one, and a cycle that is
/// followed by a frame with a correct checksum and is not shorter than that frame. A gap below 1.25
/// periods ends a cycle if SLO shows that the encoder went idle in it.
///
/// A master may pause its clock for longer within a request. Failed cycles wait for the cycles that
/// follow within the encoder's timeout. They are one cycle if only together they are a good frame
/// with a checksum and STOP, or if the timeout is known. Until then their rows are not delivered.
///
/// Memory is bounded by the longest cycle, for captures of any length.
class Decoder {
 public:
  using OnCycle = std::function<void(const Cycle&)>;

  Decoder(CycleReader reader, OnCycle on_cycle)
      : reader_(std::move(reader)), on_cycle_(std::move(on_cycle)) {}

  /// Changes in time order, MA and SLO mixed as they come. The first change of a line gives its
  /// initial level.
  void push_ma(LevelChange change);
  void push_slo(LevelChange change);

  /// The same for a capture's edges; edges of other lines are ignored.
  void push(std::span<const wire::Edge> edges, const Lines& lines);

  /// The same for the next stretch of a capture as arrays, with the clean cycles in it: a clean
  /// cycle is emitted unchanged if the decoder waits for a request when it begins. The first change
  /// of a line may repeat its level. A run begins and ends anywhere; no edge comes twice.
  void push(const PairRun& run, std::span<const CleanCycle> clean) {
    push(run, {}, run.end(), clean);
  }
  /// The same for the part of a run that contains the clean cycles.
  void push(const PairRun& run, RunPlace from, RunPlace to, std::span<const CleanCycle> clean);

  /// The capture ends at this time, which is not before its last edge; reads the rest.
  void finish(Picoseconds end_time);

 private:
  // More edges than the longest frame (ACK and line delay included) are not a request.
  static constexpr std::size_t max_cycle_edges = 2 * (max_frame_bits + 64);
  // This many edges in less than half their expected time are a faster clock than the estimate.
  static constexpr std::size_t faster_clock_edges = 24;
  static constexpr std::size_t faster_clock_step = 8;

  // The first edges of ma_ as a cycle.
  struct Doubt {
    std::size_t edges = 0;
    CycleReading reading;
  };
  // A cycle that failed, and may be the beginning of one with a pause.
  struct Held {
    CycleReading reading;
    // Its first edge in held_edges_.
    std::size_t begin = 0;
  };

  void push_mixed(const PairRun& run, RunPlace from, RunPlace to);
  bool may_join(const CycleReading& reading, Picoseconds next) const;
  void emit_clean(const CleanCycle& clean, const PairRun& run);
  bool waits() const;
  bool waits_since_this_edge() const;
  void drain(bool at_end);
  bool find_begin(bool at_end);
  bool take_cycle(bool at_end);
  CycleReading read(std::size_t begin, Picoseconds next, bool last_of_capture);
  bool is_over(const CycleReading& reading) const;
  bool repeats(const CycleReading& reading) const;
  bool frame_after_doubt(Picoseconds next, bool last_of_capture);
  bool frame_after_unknown(Picoseconds next, bool last_of_capture);
  bool proves_a_cycle(std::size_t begin, Picoseconds next, bool last_of_capture);
  bool begins_with_pulse() const;
  std::optional<CycleReading> read_before_pause(Picoseconds next);
  bool emit_before_frame(const CycleReading& reading, Picoseconds next, bool last_of_capture);
  void emit(const CycleReading& reading);
  Picoseconds longest_pause(const Cycle& cycle) const;
  bool is_right(const CycleReading& reading) const;
  bool may_begin(const Cycle& cycle) const;
  bool may_wait(const Cycle& cycle, Picoseconds pause) const;
  bool emit_joined(std::size_t end, Picoseconds limit, bool last_of_capture, bool waits);
  bool may_be_request(std::size_t rises, const Cycle& first) const;
  bool is_joined(const CycleReading& joined, Picoseconds after, bool waits) const;
  void deliver_held();
  void deliver(const Cycle& cycle);
  void hand_on(const Cycle& cycle);
  void hand_on_unjudged(const Cycle* next);
  void emit_before_doubt();
  void give_up();
  void skip(Picoseconds time);
  void follow_clock(Picoseconds begin, Picoseconds end);
  void drop_return_to_idle();
  bool is_long(Picoseconds gap) const { return 4 * gap > 5 * period_; }
  Picoseconds period_ahead() const;
  Picoseconds pause_ahead() const;
  std::int64_t clocks_between(std::size_t first, std::size_t end, Picoseconds period) const;

  CycleReader reader_;
  OnCycle on_cycle_;
  LineHistory slo_;
  // From the first edge of the current cycle on; edges before scanned_ belong to it.
  std::vector<LevelChange> ma_;
  std::size_t scanned_ = 0;
  // The edges before the last doubtful gap, as a cycle.
  std::optional<Doubt> doubt_;
  Picoseconds period_{};
  // A gap of MA longer than this is between two requests, or comes from jitter.
  Picoseconds pause_{};
  // Cycles that wait for the cycles after them, and their edges.
  std::vector<Held> held_;
  std::vector<LevelChange> held_edges_;
  // Rising edges of the last good row, and the latest release of SLO in a good row, less the line
  // delay.
  std::size_t usual_rises_ = 0;
  std::optional<Picoseconds> seen_timeout_;
  // Length of the last whole cycle, 0 when there was none.
  std::int64_t usual_clocks_ = 0;
  // The line delay of the last good cycle, whether the good cycle before it had the same, and
  // whether the last cycle was a pulse of MA.
  std::optional<Picoseconds> usual_delay_;
  bool steady_delay_ = false;
  bool after_pulse_ = false;
  // Waits for the cycle that has its checksum.
  std::optional<Cycle> unjudged_;
  Picoseconds begin_time_{};
  Picoseconds end_time_{};
  wire::Level ma_level_ = wire::Level::unknown;
  bool idle_known_ = false;
  // MA ran on for longer than any request; its edges are skipped until the next long gap.
  bool skipping_ = false;
  Picoseconds last_skipped_{};
  // The clock of the skipped edges is measured from here.
  Picoseconds skipped_mark_{};
  std::size_t skipped_edges_ = 0;
};

}  // namespace biss::decode
