// What a capture shows about its link: counts and times over all cycles, in bounded memory.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "decode/cycle_edges.hpp"
#include "decode/distribution.hpp"
#include "explain/symptom.hpp"

namespace biss::explain {

/// How often a symptom was seen, and where.
struct Sightings {
  std::uint64_t count = 0;
  std::uint64_t first_cycle = 0;
  std::uint64_t last_cycle = 0;
  Picoseconds first_time{};
};

/// The smallest step of all edge times, where the capture has sampled the lines.
///
/// A file of changes does not give its sample period. Where all gaps between edges are whole
/// multiples of the smallest one, and one level of MA lasts a step more at times, that gap is the
/// sample period. (High and low alone may differ by a step: an uneven duty does that.)
class SampleGrid {
 public:
  void push(wire::Edge edge, wire::LineIndex ma);
  /// Nothing where the edges lie on no coarse grid.
  std::optional<Picoseconds> step() const;

 private:
  bool varies_by(Picoseconds step) const;

  static constexpr std::size_t gaps_kept = 4096;
  std::vector<Picoseconds> gaps_;
  // How long MA was low and high.
  std::array<std::vector<Picoseconds>, 2> ma_levels_;
  std::optional<Picoseconds> last_;
  std::optional<Picoseconds> last_ma_;
  std::size_t slo_edges_ = 0;
};

/// Counts over a capture. Public data: filled by Observer, read by diagnose().
struct Evidence {
  /// Cycles, without those that an end of the capture cuts.
  std::uint64_t cycles = 0;
  std::uint64_t good = 0;
  std::array<Sightings, symptom_count> symptoms{};
  /// Good frames with nW = 0.
  Sightings warnings;
  /// Cycles by status.
  std::array<std::uint64_t, decode::cycle_status_count> statuses{};

  /// A format was given, so that checksums are judged.
  bool has_format = false;
  /// Bits of all checksums in the format.
  unsigned crc_bits = 0;
  unsigned payload_bits = 0;
  /// Cycles with ACK in time and START, and those with a good frame among them.
  std::uint64_t answered = 0;
  std::uint64_t passed = 0;
  /// Of frames with a wrong checksum: their number, with the last CRC bit 0, and with STOP 1.
  std::uint64_t failed_checks = 0;
  std::uint64_t last_bit_low = 0;
  std::uint64_t stop_high = 0;
  /// Of frames with right checksums and STOP 1: those with the last CRC bit 1.
  std::uint64_t stops_like_last_bit = 0;
  /// Of requests that end before the last bit of the format: their number, with the last bit 0, and
  /// whether the bit before it changes.
  std::uint64_t truncated = 0;
  std::uint64_t truncated_low = 0;
  bool before_last_changes = false;
  /// A usual checksum ends just before the last bit in all of them.
  bool usual_checksum = false;
  decode::Distribution truncated_ack_clocks;
  decode::Distribution missing_bits;
  /// Of good cycles.
  decode::Distribution ack_clocks;
  decode::Distribution good_rest;
  decode::Distribution release;
  /// Rising edges of MA after STOP, in good cycles with a format.
  decode::Distribution extra_clocks;
  /// Of all cycles in which they were measured.
  decode::Distribution period;
  decode::Distribution line_delay;
  decode::Distribution ack;
  decode::Distribution rising_edges;
  decode::Distribution rest_of_bad;
  decode::Distribution early;
  /// Line delays that differ from the first one by half a period or more.
  std::uint64_t far_delays = 0;
  std::uint64_t marginal = 0;
  std::uint64_t margin_judged = 0;
  /// Worst of all cycles.
  Picoseconds smear{};
  std::optional<Picoseconds> shortest_pulse;
  std::uint64_t pulses_on_ma = 0;
  std::uint64_t pulses_on_slo = 0;
  /// Runs of cycles in which SLO stays high, and the longest one.
  std::uint64_t silent_runs = 0;
  std::uint64_t longest_silence = 0;
  /// All edges in the capture.
  std::uint64_t ma_edges = 0;
  std::uint64_t slo_edges = 0;
  /// Given, or found by SampleGrid; 0 where edges are exact.
  Picoseconds resolution{};

  const Sightings& seen(Symptom symptom) const {
    return symptoms[static_cast<std::size_t>(symptom)];
  }
  std::uint64_t count(Symptom symptom) const { return seen(symptom).count; }
  std::uint64_t status(decode::CycleStatus status) const {
    return statuses[static_cast<std::size_t>(status)];
  }
  /// Where STOP is 1, it always repeats the bit before it: the encoder has missed the last clock.
  bool stop_repeats() const {
    const std::uint64_t high = status(decode::CycleStatus::stop_bit);
    return high >= 8 && stops_like_last_bit == high;
  }
};

/// Reads a capture once.
class Observer {
 public:
  Observer(const std::optional<FrameFormat>& format, const DeviceTiming& timing,
           const decode::MarginSetup& margin, const decode::Lines& lines);
  // The reader calls back into this object.
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

  /// Only the cycles that this function wants are observed. \pre before push()
  void set_wanted(std::function<bool(const decode::Cycle&)> wanted) { wanted_ = std::move(wanted); }

  void push(std::span<const wire::Edge> edges);
  /// \return valid as long as this object
  const Evidence& finish(Picoseconds end_time);

 private:
  void take(const decode::CycleEdges& edges);
  void note(Symptom symptom, const decode::CycleEdges& edges);
  void note_frame(const decode::Cycle& cycle);
  void note_truncated(const decode::Cycle& cycle);
  void note_times(const decode::CycleEdges& edges, bool good);
  void settle();

  decode::Lines lines_;
  Evidence evidence_;
  SampleGrid grid_;
  SymptomReader symptoms_;
  decode::CycleEdgeReader cycles_;
  std::function<bool(const decode::Cycle&)> wanted_;
  std::uint64_t silence_ = 0;
  std::optional<Picoseconds> first_delay_;
  std::optional<bool> bit_before_last_;
  // Bit k: the usual checksum of that number fits all truncated frames so far.
  unsigned fitting_checksums_ = ~0U;
  // The last CRC bit of the good frames, and whether it changes.
  std::optional<bool> last_crc_bit_;
  bool last_crc_bit_changes_ = false;
};

}  // namespace biss::explain
