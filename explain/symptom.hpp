// What is unusual about one request cycle: one symptom, read from its bits, its edges and the good
// cycles before it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "decode/cycle_edges.hpp"
#include "decode/sequence_rules.hpp"

namespace biss::explain {

enum class Symptom : std::uint8_t {
  none,           ///< a good cycle
  error_flag,     ///< a good frame with nE = 0
  life_jump,      ///< a good frame whose sign of life is not one more than before
  ma_pulse,       ///< a pulse on MA, much shorter than its clocks
  ma_uneven,      ///< an edge of MA is missing or too many, without a pulse
  slo_pulse,      ///< a pulse on SLO, much shorter than a bit
  silent,         ///< SLO stayed high
  busy,           ///< SLO was low at the request and rose later
  stuck,          ///< SLO was low until the next request
  inverted,       ///< a good answer when SLO is inverted
  half_early,     ///< SLO changes with the falling edges of MA
  early,          ///< SLO fell long before the edge of ACK
  cut_in_ack,     ///< MA stopped before START, or START came so late that bits are missing
  cut_short,      ///< START came in time, and MA stopped before the last bit
  other_ack,      ///< START outside the bounds of the encoder, the frame otherwise good
  cds_high,       ///< CDS is 1 where the format says 0, the frame otherwise good
  stop_high,      ///< STOP is 1, the frame otherwise good
  late_answer,    ///< ACK came clocks later than usual
  tail_high,      ///< SLO stayed high from a bit on to the end, STOP included
  tail_low,       ///< SLO stayed low from a bit on to the end
  smeared,        ///< SLO changes far from its usual place in a bit
  delay_changed,  ///< good, but the line delay has changed by a good part of a period
  slipped,        ///< bits are shifted by a clock
  flipped,        ///< bits are wrong
};

inline constexpr std::size_t symptom_count = 24;

/// A few words for the evidence: "… in N of M cycles".
std::string_view text_of(Symptom symptom);

/// The lines of one cycle, whatever its bits are.
struct LineMarks {
  unsigned ma_pulses = 0;
  unsigned slo_pulses = 0;
  std::optional<Picoseconds> shortest_pulse;
  /// Furthest that SLO changes from its place in a bit, and how many changes are far from it.
  Picoseconds smear{};
  unsigned smeared_changes = 0;
  /// SLO rises after it was low at the request, before the next request.
  std::optional<Picoseconds> rise;
};

/// Names the symptom of each cycle. Keeps what good cycles looked like; memory does not grow.
class SymptomReader {
 public:
  SymptomReader(const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                const decode::MarginSetup& margin);
  // The rules refer to the tallies of this object.
  SymptomReader(const SymptomReader&) = delete;
  SymptomReader& operator=(const SymptomReader&) = delete;

  Symptom read(const decode::CycleEdges& edges);

  /// Of the cycle read last.
  const LineMarks& marks() const { return marks_; }
  /// From the last edge of MA in the cycle before to the request, of the cycle read last.
  std::optional<Picoseconds> rest_before() const { return rest_before_; }

 private:
  LineMarks mark(const decode::CycleEdges& edges) const;
  void mark_ma(const decode::CycleEdges& edges, LineMarks& marks) const;
  void mark_slo(const decode::CycleEdges& edges, LineMarks& marks) const;
  Symptom of_status(const decode::CycleEdges& edges);
  Symptom of_low_request(const decode::CycleEdges& edges);
  Symptom of_early(const decode::CycleEdges& edges) const;
  Symptom of_short(const decode::CycleEdges& edges) const;
  Symptom of_bits(const decode::CycleEdges& edges) const;
  Symptom of_good(const decode::Cycle& cycle) const;
  bool answers_inverted(const decode::CycleEdges& edges);
  bool slips(const decode::Cycle& cycle) const;
  bool life_jumps(const decode::CycleEdges& edges);
  std::optional<std::int64_t> delay_off(const decode::Cycle& cycle) const;
  void learn(const decode::Cycle& cycle);

  std::optional<FrameFormat> format_;
  decode::CycleReader again_;
  Picoseconds resolution_{};
  LineMarks marks_;
  // Judges the sign of life.
  decode::Tallies tallies_;
  decode::SequenceRules sequence_;
  bool has_sign_of_life_ = false;
  bool life_jumps_ = false;
  // Of good cycles.
  std::optional<Picoseconds> usual_delay_;
  std::uint16_t longest_ack_ = 0;
  decode::RawBits last_good_;
  std::uint32_t fewest_clocks_ = std::numeric_limits<std::uint32_t>::max();
  std::optional<Picoseconds> shortest_rest_;
  std::optional<Picoseconds> last_edge_;
  std::optional<Picoseconds> rest_before_;
};

}  // namespace biss::explain
