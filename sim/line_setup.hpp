// What stands on the line and how it behaves.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/control/session.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"
#include "sim/control_master.hpp"
#include "sim/encoder_registers.hpp"
#include "sim/fault.hpp"
#include "sim/motion.hpp"
#include "sim/sign_of_life.hpp"

namespace biss::sim {

/// A master, a cable, one encoder or a chain of them. A time of 0 means what it says unless
/// another meaning is named.
struct LineSetup {
  /// All channels as the master sees them.
  FrameFormat format;
  DeviceTiming timing;
  Hertz clock = megahertz(1);
  /// How far the master's oscillator is off, in parts of a million, at most 100000 either way;
  /// more is faster.
  std::int32_t clock_error_ppm = 0;
  /// Share of a period that MA is high, in thousandths: 1 to 999.
  std::uint32_t duty_per_mille = 500;
  /// In the cable, one way each; at most 40 µs.
  Picoseconds ma_delay{};
  Picoseconds slo_delay{};
  /// MA to SLO inside each encoder; at most 40 µs.
  Picoseconds internal_delay{};
  /// Each edge comes up to so much earlier or later, but never before the one ahead of it; at
  /// most the delay of its direction, for SLO with the internal one.
  Picoseconds ma_jitter{};
  Picoseconds slo_jitter{};
  /// Devices one behind the other, 1 to the number of channels. Those next to the master have a
  /// channel each, the one at the far end the rest.
  std::uint8_t slaves = 1;
  /// From ACK until an encoder has its answer; never sooner than the device can.
  Picoseconds processing{};
  bool compensate = true;
  /// From one request to the next; less than a cycle takes: as soon as the encoder is ready. 0:
  /// when SLO has been seen high for a period, which every decoder takes.
  Picoseconds interval{};
  MotionKind motion = MotionKind::ramp;
  /// Of every encoder: how its signs of life count.
  SignOfLife life;
  /// Each word of an encoder behind its first one shows a position that is so many counts of the
  /// first one's further with each cycle, from the first one on.
  std::int32_t drift = 0;
  std::uint64_t seed = 1;
  std::vector<FaultRule> faults;
  /// Of the encoders, that at the far end first, which has ID 0. None: all are unidirectional.
  /// Fewer than there are encoders: the others have an ID, too, and refuse every access. What is
  /// written lasts until an encoder loses its supply.
  std::vector<EncoderRegisters> registers;
  /// What the master does over CDM and CDS, and how.
  std::vector<ControlAccess> accesses;
  ControlOptions control;
  bool has_control() const { return !registers.empty() || !accesses.empty(); }
  /// Also record MA and SLO as the encoder next to the master has them.
  bool record_at_slave = false;
};

/// The least interval at which the encoder is ready each time, behind a CDM of 1, too, where
/// has_control(): never more than cycle_budget() says, but for jitter; at an interval of 0 with SLO
/// high for a period as the master sees it. Found by running the line for some cycles, without
/// faults.
Picoseconds least_interval(const LineSetup& setup);

}  // namespace biss::sim
