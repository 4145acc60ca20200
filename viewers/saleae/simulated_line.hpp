// The simulated data of Logic 2 without a device: a turning encoder of the chosen format.
#pragma once

#include <SimulationChannelDescriptor.h>

#include <cstdint>

#include "biss/frame/codec.hpp"
#include "viewers/saleae/settings.hpp"

namespace logic {

class SimulatedLine {
 public:
  SimulatedLine(Settings& settings, U32 sample_rate);

  /// Writes whole request cycles up to this sample or after it. \return the number of channels
  U32 run_until(U64 sample, SimulationChannelDescriptor** channels);

 private:
  static constexpr U32 samples_per_half_clock = 4;
  static constexpr std::uint32_t ack_clocks = 8;
  static constexpr U32 idle_half_clocks = 64;

  void write_cycle();
  void put_clock(bool slo);
  void put_slo(bool level);

  biss::FrameCodec<> codec_;
  biss::saleae::RowSetup setup_;
  SimulationChannelDescriptorGroup group_;
  SimulationChannelDescriptor* ma_;
  SimulationChannelDescriptor* slo_;
  std::uint64_t position_ = 0;
};

}  // namespace logic
