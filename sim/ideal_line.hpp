// Master, cable and encoder on an ideal line: no jitter, no noise, every edge where the data sheet
// puts it. Bits may be flipped on purpose.
#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "biss/frame/encode.hpp"
#include "biss/timing/device_timing.hpp"
#include "sim/motion.hpp"
#include "wire/edge.hpp"

namespace biss::sim {

/// Index of each line in the edges made here.
inline constexpr wire::LineIndex ma_line = 0;
inline constexpr wire::LineIndex slo_line = 1;

struct IdealLineSetup {
  FrameFormat format;
  DeviceTiming timing;
  Hertz clock = megahertz(1);
  /// There and back, cable and encoder together.
  Picoseconds line_delay{};
  /// From one request to the next; 0, or less than a cycle takes: as soon as the encoder is ready.
  Picoseconds interval{};
  MotionKind motion = MotionKind::ramp;
  /// Share of cycles in which one bit of data or CRC is flipped on the line, in parts of 2^32.
  std::uint64_t flip_share = 0;
  std::uint64_t seed = 1;
};

/// One request cycle: its edges as seen at the master, and what the encoder meant to send.
struct SimulatedCycle {
  Picoseconds time{};  ///< the first falling edge of MA
  Frame sent;
  std::vector<wire::Edge> edges;
  bool flipped = false;
};

/// Makes one cycle after the other; the first request comes after 20 periods of idle.
class IdealLine {
 public:
  /// \pre setup.format has a channel, setup.clock is positive
  explicit IdealLine(const IdealLineSetup& setup);

  SimulatedCycle next();

  /// The least interval at which this encoder is ready each time, ACK at its shortest.
  Picoseconds least_interval() const;

 private:
  Frame next_frame();
  Picoseconds release_time(Picoseconds begin, Picoseconds last_edge) const;
  void put_edges(const FrameBits& bits, Picoseconds begin, SimulatedCycle& cycle) const;

  IdealLineSetup setup_;
  FrameCodec<> codec_;
  Motion motion_;
  std::mt19937_64 random_;
  Picoseconds period_;
  std::uint16_t ack_clocks_;
  std::uint32_t life_counter_ = 0;
  Picoseconds begin_;
};

}  // namespace biss::sim
