// A request cycle: the answer to one request on MA, or the one cause why it is not a frame.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/frame.hpp"
#include "biss/frame/status.hpp"
#include "decode/line_signal.hpp"

namespace biss::decode {

/// The bits from START to STOP as received: START, CDS, the payload and STOP.
using RawBits = BitBuffer<max_payload_bits + 3>;

/// How much the clock changes within a request: the largest difference between two times of 1, 2, 4
/// or 8 periods of MA.
struct ClockChange {
  /// The clock of a request may change by at most a period divided by this: edges may jitter.
  static constexpr std::int64_t divisor = 4;

  Picoseconds most{};
  /// The part of `most` that may come from jitter and from the resolution of the capture; 0 if the
  /// change is within this limit.
  Picoseconds doubt{};
};

/// All edges of MA were seen, and are the clocks of one request.
constexpr bool has_whole_clock(CycleStatus status) {
  return !is_cut(status) && status != CycleStatus::ma_glitch && status != CycleStatus::ma_clock &&
         status != CycleStatus::unknown_level;
}

/// A request cycle and its measurements. An absent value could not be measured.
struct Cycle {
  /// The first falling edge of MA, or the first edge in the capture if that one is before it. Counts
  /// from the zero point of the capture.
  Picoseconds time{};
  CycleStatus status = CycleStatus::ok;
  /// Present if the status is ok.
  std::optional<Frame> frame;
  /// For each channel of the format: its checksum was right. Absent if some of its bits are missing or
  /// it has no checksum.
  std::array<std::optional<bool>, max_channels> crc_ok{};
  /// Second rising edge of MA to the first falling edge of SLO. Also absent if the previous cycle
  /// was a pulse, which the encoder may take as the first clock, and no cycle shows the usual
  /// delay.
  std::optional<Picoseconds> line_delay;
  /// The rising edge of MA, from 0 on, that line_delay counts from: 0 if the encoder has taken a
  /// pulse as its first clock, 2 if it has missed a clock.
  std::uint32_t ack_edge = 1;
  /// With `response_range`: SLO fell this long before the edge of MA that makes ACK.
  std::optional<Picoseconds> early;
  /// SLO falling to START rising, as seen at the master.
  std::optional<Picoseconds> ack;
  /// The mean period of MA.
  std::optional<Picoseconds> period;
  /// Share of a period that MA is high, in thousandths.
  std::optional<std::uint32_t> duty_per_mille;
  /// SLO changes within a twentieth of a period of a sampling point of the master, from ACK to STOP
  /// (MarginSetup). Absent if nothing was sampled, or the capture is too coarse.
  std::optional<bool> marginal;
  /// Rising edges of MA.
  std::uint32_t rising_edges = 0;
  /// Pauses of MA before the last bit, and by how much the longest one is longer than a period. The
  /// row of a request with pauses is `ma_clock` unless it is certain that no clock is missing.
  std::uint32_t pauses = 0;
  Picoseconds longest_pause{};
  /// From `time` to the last edge of MA.
  Picoseconds clocked{};
  /// How much a time between two edges of this cycle may be off: the resolution of the capture and
  /// the jitter of MA, up to a quarter of a period.
  Picoseconds uncertainty{};
  /// Present only for a device with DeviceTiming::clock_constant.
  std::optional<ClockChange> clock_change;
  /// Empty if no START was seen.
  RawBits raw;
  /// The master's bit: 1 if MA rests low after the frame. Absent if the capture does not show it.
  std::optional<bool> cdm;
  /// Last edge of MA to the rising edge of SLO after the frame, at the master: the timeout plus the
  /// line delay; negative if SLO rises while MA still runs. Absent if SLO was not low after the
  /// frame, did not rise before the next request, or fell again.
  std::optional<Picoseconds> release;
  /// Present only if MarginSetup::signal is set.
  std::optional<LineSignal> signal;

  /// The encoder's bit after START, for any status.
  std::optional<bool> cds() const {
    if (raw.view().size_bits() < 2) return std::nullopt;
    return raw.view()[1];
  }
};

}  // namespace biss::decode
