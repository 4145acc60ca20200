// From the edges of one request cycle to the row it becomes: clock, line delay, bits, frame or
// cause.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/line_history.hpp"

namespace biss::decode {

/// The edges of MA that belong to one request, first to last, and what lies around them.
struct CycleSpan {
  std::span<const LevelChange> ma;
  /// MA was seen idle before the first edge; false only where the capture begins inside a cycle.
  bool begins_idle = true;
  /// Up to here SLO belongs to this cycle: the next request's begin, or the end of the capture.
  Picoseconds limit{};
  /// `limit` is the end of the capture.
  bool last_of_capture = false;
};

/// A row, and whether all bits that the format asks for were there to sample.
struct CycleReading {
  Cycle cycle;
  bool complete = false;
};

/// Reads cycles as the master would see them: SLO is sampled at each rising edge of MA plus the
/// line delay of that cycle plus half a period. Keeps no state from one cycle to the next.
class CycleReader {
 public:
  /// Without a format only structure is judged: `ok` then means that START was found, and no
  /// position is given.
  CycleReader(std::optional<FrameFormat> format, const DeviceTiming& timing);

  /// \param slo must reach back to the span's first edge
  CycleReading read(const CycleSpan& span, const LineHistory& slo) const;

 private:
  struct Clock {
    Picoseconds period{};
    std::vector<Picoseconds> rises;
    /// Index into `rises` of the first edge whose distance from the one before is not a period.
    std::size_t first_irregular = SIZE_MAX;
  };
  struct Sampled {
    FrameBits bits;
    bool reached_limit = false;
    bool reached_unknown = false;
  };

  static Clock measure_clock(std::span<const LevelChange> ma, Cycle& cycle);
  static std::optional<CycleStatus> find_response(const CycleSpan& span, const LineHistory& slo,
                                                  const Clock& clock, Cycle& cycle);
  static Sampled sample(const CycleSpan& span, const LineHistory& slo, const Clock& clock,
                        Picoseconds line_delay);
  CycleReading judge(const CycleSpan& span, const Sampled& sampled, const Clock& clock,
                     CycleReading reading) const;
  void read_payload(const Sampled& sampled, const FrameStart& start, CycleReading& reading) const;

  std::optional<FrameCodec<>> codec_;
  DeviceTiming timing_;
};

}  // namespace biss::decode
