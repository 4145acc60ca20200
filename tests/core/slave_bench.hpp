// A slave's owner that keeps a log, and a clock of 1 MHz.
#pragma once

#include <cstdint>

#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"

namespace biss::test {

/// The calls that the owner received.
struct Log {
  std::uint64_t position = 0;
  bool cds = false;
  std::uint32_t samples = 0;
  Picoseconds sampled_at{};
  std::uint32_t cdm_count = 0;
  bool cdm = false;
};

template <class Frame>
struct Owner {
  Log* log;

  constexpr Frame sample(Picoseconds moment) {
    ++log->samples;
    log->sampled_at = moment;
    Frame frame;
    for (auto& channel : frame.channel_list) channel.position = log->position;
    return frame;
  }
  constexpr bool cds(bool predecessor) { return predecessor || log->cds; }
  constexpr void cdm(bool bit) {
    ++log->cdm_count;
    log->cdm = bit;
  }
};

using TestCodec = FrameCodec<CrcFast, 2>;
using TestSlave = Slave<TestCodec, Owner<TestCodec::Frame>>;

inline constexpr Picoseconds period = microseconds(1);
inline constexpr Picoseconds half = nanoseconds(500);

}  // namespace biss::test
