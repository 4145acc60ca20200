// Reads one request cycle from its edges: clock, line delay, bits, and the frame or the cause.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/line_history.hpp"

namespace biss::decode {

/// The edges of MA that belong to one request, and the time around them.
struct CycleSpan {
  /// Not empty.
  std::span<const LevelChange> ma;
  /// MA was seen idle before the first edge; false only if the capture begins inside a cycle.
  bool begins_idle = true;
  /// SLO belongs to this cycle up to here: the next request, or the end of the capture.
  Picoseconds limit{};
  /// `limit` is the end of the capture.
  bool last_of_capture = false;
  /// The clocks that a request with pauses must have; 0: not known. With a different number, a
  /// pause may be clocks that the capture lost.
  std::size_t usual_clocks = 0;
};

/// A cycle, and whether it is complete: all bits of the format were sampled, or more clocks could
/// add nothing.
struct CycleReading {
  Cycle cycle;
  /// Longest less shortest period of MA in this cycle; see docs/status.md, `response_range`.
  Picoseconds jitter{};
  bool complete = false;
};

/// How Cycle::marginal is judged.
struct MarginSetup {
  /// The master compensates the line delay and samples when this reader does. Else it samples half
  /// a period after each rising edge of MA, one bit a clock; this reader still compensates.
  bool compensated = true;
  /// Every edge may have been earlier by less than this: the time between two samples of the
  /// capture, 0 if it contains changes. `marginal` is given only if it is certain, and SLO may seem
  /// to fall this much before the edge of MA that caused the fall.
  Picoseconds resolution{};
  /// Also measure Cycle::signal.
  bool signal = false;
};

/// Reads cycles as the master would see them: SLO is sampled at each rising edge of MA plus the
/// line delay of that cycle plus half a period. Nothing is carried from one cycle to the next.
class CycleReader {
 public:
  /// Without a format only the structure is judged: a cycle in which START was found is then
  /// `unchecked`, and has no frame.
  CycleReader(std::optional<FrameFormat> format, const DeviceTiming& timing,
              const MarginSetup& margin = {});

  /// \param slo must reach back to the span's first edge
  CycleReading read(const CycleSpan& span, const LineHistory& slo);

  /// With a format whose CRC belongs to the previous frame, a cycle is `unchecked` and has its
  /// frame: the next cycle has the checksum.
  bool needs_next() const { return checked_by_next_.has_value(); }
  /// Judges such a cycle; without a next one, or if the next one lacks these bits, it stays
  /// `unchecked` and loses its frame.
  void judge_by_next(Cycle& cycle, const Cycle* next) const;
  /// The format's payload bits, if the format has a checksum.
  std::optional<std::size_t> checked_payload_bits() const;
  const DeviceTiming& timing() const { return timing_; }
  /// The default timeout counts as unknown.
  bool knows_timeout() const { return timing_.timeout != Timeout{}; }
  /// Reads bits that were sampled elsewhere, SLO once per clock from the first one on, for an ACK
  /// as long as BiSS C allows. The cycle has no times.
  Cycle read_bits(const BitView& bits) const;

  /// The times at which the last read() sampled SLO: element k belongs to rising edge k of MA, LAT
  /// included. Empty if SLO gave no ACK.
  std::vector<Picoseconds> sample_times() const;

 private:
  // The clock of this cycle. A member, so that its memory is used again.
  struct Clock {
    Picoseconds period{};
    // Difference of the longest and the shortest distance of two rising edges that is a period.
    Picoseconds jitter{};
    std::vector<Picoseconds> rises;
    std::vector<Picoseconds> even_rises;
    std::vector<Picoseconds> intervals;
    // Index into `rises` of the first edge whose distance from the previous one is not a period,
    // and of the first edge that is too early.
    std::size_t first_irregular = SIZE_MAX;
    std::size_t first_early = SIZE_MAX;
  };
  struct Sampled {
    FrameBits bits;
    bool reached_limit = false;
    bool reached_unknown = false;
    // Rising edge of the first sample that was too close to a change of SLO.
    std::size_t first_marginal = SIZE_MAX;
  };
  // When SLO fell for ACK, or why that is not known.
  struct Response {
    Picoseconds fall{};
    CycleStatus status = CycleStatus::ok;
  };

  // From MA to SLO, and the spread over the changes of a cycle.
  struct Delay {
    Picoseconds mean{};
    Picoseconds spread{};
  };

  // The values of an answered request from which read() measures its signal.
  struct Answer {
    Picoseconds fall{};
    Picoseconds delay{};
    // Index of the rising edge of STOP; with a format only.
    std::optional<std::size_t> stop;
  };

  CycleReading read_answer(const CycleSpan& span, const LineHistory& slo);
  LineSignal signal(const CycleSpan& span, const LineHistory& slo, const Cycle& cycle) const;
  void measure_clock(std::span<const LevelChange> ma, Cycle& cycle);
  Picoseconds usual_period();
  Picoseconds uncertainty() const;
  ClockChange measure_change() const;
  Picoseconds jitter_in_doubt() const;
  void measure_duty(std::span<const LevelChange> ma, Cycle& cycle) const;
  Response find_response(const CycleSpan& span, const LineHistory& slo) const;
  bool ready_in_time(const LineHistory& slo, std::size_t ack) const;
  std::optional<bool> resting_level(const CycleSpan& span) const;
  std::optional<Picoseconds> release(const CycleSpan& span, const LineHistory& slo,
                                     Picoseconds delay, std::size_t last_bit) const;
  CycleStatus silence(const CycleSpan& span) const;
  Picoseconds sampling_delay(const LineHistory& slo, Picoseconds fall);
  Delay delay_from(const std::vector<Picoseconds>& rises, const LineHistory& slo,
                   Picoseconds fall) const;
  bool lay_even_clock();
  Sampled sample(const CycleSpan& span, const LineHistory& slo, Picoseconds delay) const;
  Picoseconds certain_margin() const;
  std::optional<bool> judge_margin(const CycleSpan& span, const LineHistory& slo, Picoseconds fall,
                                   const Sampled& sampled, std::size_t start) const;
  using FoundStart = Result<FrameStart, FrameFault>;
  void judge(const CycleSpan& span, const LineHistory& slo, Picoseconds delay,
             const Sampled& sampled, const FoundStart& start, CycleReading& reading) const;
  bool pauses_are_certain(const CycleSpan& span, const LineHistory& slo, Picoseconds delay,
                          std::size_t last_bit, Cycle& cycle) const;
  bool outlasts(Picoseconds pause) const;
  void read_payload(const Sampled& sampled, const FrameStart& start, CycleReading& reading) const;
  void note_checksums(const std::optional<FrameFault>& fault, Cycle& cycle) const;
  std::optional<CycleStatus> fault_of_capture(const CycleSpan& span, const Sampled& sampled,
                                              CycleStatus status) const;

  std::optional<FrameCodec<>> codec_;
  // The format, if its CRC belongs to the previous frame; codec_ treats this CRC as padding.
  std::optional<FrameFormat> checked_by_next_;
  DeviceTiming timing_;
  MarginSetup margin_;
  Clock clock_;
  std::optional<Answer> answer_;
  // The first change of SLO that does not belong to this request.
  std::size_t slo_end_ = 0;
  // From a rising edge of MA to the sample of its bit, in the last read().
  std::optional<Picoseconds> sampled_after_;
};

}  // namespace biss::decode
