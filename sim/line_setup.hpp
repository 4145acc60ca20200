// The devices on the line and their behaviour.
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

/// A master, a cable, and one encoder or a daisy chain of encoders.
struct LineSetup {
  /// All channels as the master sees them.
  FrameFormat format;
  DeviceTiming timing;
  Hertz clock = megahertz(1);
  /// The deviation of the master's oscillator in parts per million, -100000 to 100000; positive is
  /// faster.
  std::int32_t clock_error_ppm = 0;
  /// The share of a period in which MA is high, in thousandths: 1 to 999.
  std::uint32_t duty_per_mille = 500;
  /// In the cable, one direction each; at most 40 µs.
  Picoseconds ma_delay{};
  Picoseconds slo_delay{};
  /// From MA to SLO inside each encoder; at most 40 µs.
  Picoseconds internal_delay{};
  /// Peak edge jitter (±); an edge never comes before the previous one. At most the delay of its
  /// direction, for SLO including the internal one.
  Picoseconds ma_jitter{};
  Picoseconds slo_jitter{};
  /// Devices in a daisy chain, 1 to the number of channels. Each has one channel, the one at the far
  /// end all further channels.
  std::uint8_t slaves = 1;
  /// From ACK until an encoder has its answer; at least the shortest time of the device.
  Picoseconds processing{};
  bool compensate = true;
  /// From one request to the next. If it is shorter than a cycle, the next request comes as soon as
  /// the encoder is ready; if it is 0, after SLO has been high for a period, which every decoder
  /// accepts.
  Picoseconds interval{};
  MotionKind motion = MotionKind::ramp;
  /// Every sample has this position, for any `motion`.
  std::optional<std::uint64_t> position;
  /// The sign of life of every encoder.
  SignOfLife life;
  /// With each cycle, the further words of an encoder move this many counts away from its first
  /// word.
  std::int32_t drift = 0;
  std::uint64_t seed = 1;
  std::vector<FaultRule> faults;
  /// MA pauses this long, high, after each `pause_clocks` clocks (0: never), and with `ma_pause`;
  /// 0: a pause of this fault is 1 to 16 periods long. The master samples nothing during a pause.
  Picoseconds pause{};
  std::uint32_t pause_clocks = 0;
  /// The number of the first cycle, and when its 20 idle periods begin.
  std::uint64_t first_cycle = 0;
  Picoseconds begin{};
  /// One entry for each encoder, starting with the far end, which has ID 0. Empty: all are
  /// unidirectional. If there are fewer entries than encoders, the other encoders have an ID, too,
  /// and refuse every access. Written values last until an encoder loses its supply.
  std::vector<EncoderRegisters> registers;
  /// The accesses of the master over CDM and CDS, and their options.
  std::vector<ControlAccess> accesses;
  ControlOptions control;
  bool has_control() const { return !registers.empty() || !accesses.empty(); }
  /// Also record MA and SLO at the encoder next to the master.
  bool record_at_slave = false;
};

/// The shortest interval at which the encoder is always ready; if has_control(), also after a CDM
/// of 1. Without jitter it is never longer than cycle_budget() returns; with an interval of 0 it
/// includes a period in which the master sees SLO high. It is measured by running the line for some
/// cycles without faults.
Picoseconds least_interval(const LineSetup& setup);

}  // namespace biss::sim
