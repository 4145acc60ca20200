// Evidence in a capture about its link: the price of each request, counts and times, in bounded
// memory.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "decode/check.hpp"
#include "decode/clean_cycles.hpp"
#include "decode/cycle_edges.hpp"
#include "decode/distribution.hpp"
#include "explain/plausibility.hpp"
#include "explain/request.hpp"

namespace biss::explain {

/// A request, or several equal ones.
struct Row {
  /// 2^-price of each kind, less the lowest price.
  std::array<float, kind_count> likely{};
  double count = 1;
};

/// A limit of the encoder or of BiSS C that was exceeded, by the rules of `biss check`.
struct Exceeded {
  decode::Rule rule{};
  decode::RuleResult result;
};

/// Counts over a capture. Public data: filled by Observer, read by diagnose().
struct Evidence {
  /// Cycles, without those that an end of the capture cuts.
  std::uint64_t cycles = 0;
  std::uint64_t good = 0;
  /// Requests by their cheapest kind.
  std::array<Sightings, kind_count> kinds{};
  std::vector<Row> rows;
  Usual usual;
  /// Good frames with nW = 0.
  Sightings warnings;
  /// Frames that MA cuts, with nE = 0.
  Sightings cut_errors;
  /// The longest time for which the turns do not match the singleturn, in frames; and steps beyond
  /// all others.
  std::uint64_t late_turns = 0;
  Sightings steps;
  std::vector<Exceeded> limits;
  /// Frames with the sign of life 0 after its highest value.
  std::uint64_t life_zeros = 0;
  /// Cycles by status.
  std::array<std::uint64_t, cycle_status_count> statuses{};
  /// A format was given, so that checksums are judged.
  bool has_format = false;
  /// Cycles with ACK in time and START, and how many of them have a good frame.
  std::uint64_t answered = 0;
  std::uint64_t passed = 0;
  /// Frames with a wrong checksum: their number, those with the last CRC bit 0, with STOP 1, and
  /// with a likely position.
  std::uint64_t failed_checks = 0;
  std::uint64_t last_bit_low = 0;
  std::uint64_t stops_high = 0;
  std::uint64_t likely_positions = 0;
  /// In requests with ACK and START: the last two bits that the master has clocked.
  std::array<std::uint64_t, 4> last_bits{};
  /// Requests that end before the last bit of the format.
  std::uint64_t truncated = 0;
  std::uint64_t truncated_low = 0;
  decode::Distribution truncated_ack_clocks;
  decode::Distribution missing_bits;
  /// In good cycles.
  decode::Distribution ack_clocks;
  decode::Distribution good_rest;
  decode::Distribution release;
  /// Rising edges of MA after STOP, in good cycles with a format.
  decode::Distribution extra_clocks;
  /// In all cycles in which they were measured.
  decode::Distribution period;
  decode::Distribution line_delay;
  decode::Distribution rising_edges;
  decode::Distribution rest_of_bad;
  /// Worst of all cycles.
  Picoseconds smear{};
  std::uint64_t pulses_on_ma = 0;
  std::uint64_t pulses_on_slo = 0;
  /// Runs of cycles in which SLO stays high, and the longest one.
  std::uint64_t silent_runs = 0;
  std::uint64_t longest_silence = 0;
  /// All edges in the capture.
  std::uint64_t ma_edges = 0;
  std::uint64_t slo_edges = 0;
  /// Given, or the step on which all edges lie; 0 if edges are exact.
  Picoseconds resolution{};

  const Sightings& seen(RequestKind kind) const { return kinds[static_cast<std::size_t>(kind)]; }
  std::uint64_t count(RequestKind kind) const { return seen(kind).count; }
  std::uint64_t status(CycleStatus status) const {
    return statuses[static_cast<std::size_t>(status)];
  }
};

/// How a capture is read.
struct ObserverSetup {
  std::optional<FrameFormat> format;
  DeviceTiming timing;
  /// By which the cycles are read, pauses of MA included.
  Timeout timeout{};
  /// Cycles should come with Cycle::signal.
  decode::MarginSetup margin;
  decode::Lines lines;
};

class Pricer;

/// Sees the cycles of a capture as the decoder delivers them, and its edges; keeps the edges of
/// unusual requests only.
class Observer {
 public:
  /// \param beginning edges from the beginning of the capture; they will be given again
  Observer(const ObserverSetup& setup, std::span<const wire::Edge> beginning);
  ~Observer();

  /// The next cycle.
  void add(std::uint64_t number, const decode::Cycle& cycle);
  /// The next edges, or the next stretch of the capture as arrays.
  void take(std::span<const wire::Edge> edges);
  void take(const decode::PairRun& run);
  /// Examines the cycles so far, whose edges must have come.
  void settle();
  /// After the last cycle. \return evidence that is valid during the life of this object
  const Evidence& finish(Picoseconds end_time);

 private:
  using Waiting = std::pair<std::uint64_t, decode::Cycle>;

  Picoseconds needed_from() const;
  bool is_cut_at_end(const decode::Cycle& cycle, Picoseconds end_of_capture) const;
  void process(const Waiting& waiting, std::optional<Picoseconds> next, bool last);
  void note_unusual(std::uint64_t number, const decode::Cycle& cycle, const Prices& prices);
  void note_frame(std::uint64_t number, const decode::Cycle& cycle);
  void note_times(const decode::Cycle& cycle, bool good);
  void add_row(const Prices& prices);
  void move_good(RequestKind to, const Sightings& seen);

  ObserverSetup setup_;
  Evidence evidence_;
  std::unique_ptr<Pricer> pricer_;
  std::vector<Plausibility> plausibility_;
  decode::Check check_;
  decode::LineHistory ma_;
  decode::LineHistory slo_;
  std::deque<Waiting> waiting_;
  Picoseconds last_end_{};
  std::uint64_t plain_ = 0;
  std::uint64_t silence_ = 0;
  // One in this many of the unusual requests has a row.
  std::uint64_t stride_ = 1;
  std::uint64_t unusual_ = 0;
  // Good frames whose sign of life is not one more than before.
  Sightings life_jumps_;
};

}  // namespace biss::explain
