// How MA and SLO look in a request: levels, pulses, and how far SLO's changes are from the sampling
// points of the master.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "biss/base/units.hpp"
#include "decode/line_history.hpp"

namespace biss::decode {

/// Measured only if MarginSetup::signal is set and MA has a period.
struct LineSignal {
  /// A level that is certainly shorter than this is a pulse: half of the shorter half of a period.
  Picoseconds pulse_max{};
  std::uint32_t ma_pulses = 0;
  std::uint32_t slo_pulses = 0;
  /// The shortest level of MA that is not a pulse.
  std::optional<Picoseconds> ma_shortest;
  /// From SLO's rise to the request; negative: SLO rose after it, or not at all in this cycle.
  /// Absent if SLO was high from the beginning of the capture.
  std::optional<Picoseconds> ready;

  /// Changes of SLO from ACK to STOP, without pulses: each minus the time of the rising edge of MA
  /// that caused it.
  struct Changes {
    Picoseconds earliest{};
    Picoseconds latest{};
    /// The delay with which a master that compensates samples; half a period is added.
    Picoseconds sampled{};
  };
  /// Only with a format; absent if START was not found or MA was not even.
  std::optional<Changes> changes;
  /// Rising edges of MA up to STOP. Only with a format.
  std::optional<std::uint32_t> frame_clocks;
};

/// A request as CycleReader sees it.
struct SignalSpan {
  std::span<const LevelChange> ma;
  /// SLO belongs to the request up to here.
  Picoseconds limit{};
  /// The first change of SLO that does not belong to this request, if that is earlier: a change at
  /// the time of the next request belongs to the next request.
  std::size_t slo_end = SIZE_MAX;
  Picoseconds period{};
  std::uint32_t duty_per_mille = 500;
  Picoseconds resolution{};
};

/// All but `changes` and `frame_clocks`. \pre span.ma is not empty, span.period is positive
LineSignal measure_signal(const SignalSpan& span, const LineHistory& slo);

/// \param rises   of MA up to STOP, all a period apart, at least two
/// \param slo_end of the changes of SLO, the first that is not of this request
/// \param fall    of SLO, for ACK
LineSignal::Changes measure_changes(std::span<const Picoseconds> rises, const LineHistory& slo,
                                    std::size_t slo_end, Picoseconds fall, Picoseconds pulse_max);

}  // namespace biss::decode
