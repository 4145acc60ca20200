// A slave's owner that keeps a log, and a chain of slaves on a clock of 1 MHz.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "biss/frame/codec.hpp"
#include "biss/slave/slave.hpp"
#include "tests/core/frames.hpp"

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

/// SLO of each slave is SLI of the next one. `bits` is the last SLO half a period after each rising
/// edge.
template <class AnySlave, std::size_t Count>
struct SlaveChain {
  std::array<AnySlave, Count> slave;
  std::array<StepOutput, Count> out{};
  Picoseconds now = microseconds(5);
  bool ma = true;
  LineBits bits{};

  constexpr void put(bool level) {
    ma = level;
    bool sli = false;
    for (std::size_t k = 0; k < Count; ++k) {
      out[k] = slave[k].step(now, ma, sli);
      sli = out[k].level;
    }
  }
  constexpr Picoseconds deadline() const {
    Picoseconds next = never;
    for (const StepOutput& each : out) next = std::min(next, each.deadline);
    return next;
  }
  constexpr void wait(Picoseconds time) {
    const Picoseconds end = now + time;
    while (deadline() <= end) {
      now = deadline();
      put(ma);
    }
    now = end;
  }
  /// From MA high: falling, rising, and half a period more.
  constexpr void clock(unsigned count) {
    for (unsigned i = 0; i < count; ++i) {
      for (const bool level : {false, true}) {
        put(level);
        wait(half);
      }
      bits.append(out[Count - 1].level);
    }
  }
};

}  // namespace biss::test
