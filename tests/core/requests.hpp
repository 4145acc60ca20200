// A master and its device for the tests of requests.
#pragma once

#include "biss/frame/encode.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/request.hpp"
#include "tests/core/frames.hpp"
#include "tests/core/scripted_slo.hpp"
#include "tests/core/test.hpp"

namespace biss::test::request {

inline constexpr Picoseconds period = nanoseconds(100);
inline constexpr FrameFormat format = format_of("pos18,nE,nW,crc6;cds0");
using Codec = FixedCodec<format>;
using Master = RequestCycle<Codec>;
using Reading = Master::Reading;

/// ACK of 4…6 clocks, ready 20 µs after the last edge.
inline constexpr DeviceTiming timing{.start_min = nanoseconds(500),
                                     .ack_max = nanoseconds(600),
                                     .timeout = {TimeoutRule::fixed, microseconds(20)},
                                     .cycle_min = microseconds(25)};
inline constexpr MasterSetup setup{.period = period, .timing = timing};
inline constexpr unsigned payload_bits = 26;

/// Levels of SLO from the first clock on: LAT, `ack` clocks of ACK, START, CDS, the channel, STOP.
inline LineBits script_of(std::uint64_t position, unsigned ack = 5) {
  auto frame = frame_of(position);
  frame.lead_clocks = 1;
  frame.ack_clocks = static_cast<std::uint16_t>(ack);
  const auto bits = encode_frame(frame, Codec{});
  LineBits line;
  for (std::size_t i = 0; i < bits->size_bits(); ++i) line.append(bits->view()[i]);
  return line;
}

inline LineBits low_from_ack() { return line_of("1"); }

inline std::uint64_t position_of(const Reading& reading) {
  return reading.frame.ok() ? reading.frame->channel_list[0].position : ~std::uint64_t{0};
}

inline FrameError cause_of(const Reading& reading) {
  BISS_EXPECT(!reading.frame.ok());
  return reading.frame.ok() ? FrameError{} : reading.frame.error().cause;
}

}  // namespace biss::test::request
