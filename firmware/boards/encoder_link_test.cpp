#include "firmware/boards/encoder_link.hpp"

#include <cstdint>
#include <limits>
#include <span>

#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "tests/core/test.hpp"

namespace boards {
namespace encoder_link_test {

constexpr biss::FrameFormat format = biss::frame_format("pos24,nE,nW,crc6");
constexpr biss::SpiReader reader{biss::FixedCodec<format>{},
                                 {.period = biss::nanoseconds(200)},
                                 biss::DeviceTiming{.ack_max = biss::microseconds(2)}};

// Every transfer ends at once, with SLO low throughout.
struct Port {
  constexpr bool start(std::span<std::uint8_t>) { return true; }
  constexpr void hold_ma_low() { ++held; }

  std::uint32_t held = 0;
};

// The bits of CDM that are 1 in a broadcast. The clock of the link wraps around in every fourth
// cycle.
constexpr std::uint32_t ones_of_a_broadcast() {
  Port port;
  const biss::Picoseconds cycle{std::numeric_limits<std::int64_t>::max() / 2};
  EncoderLink<Port, decltype(reader), reader.bytes()> link(port, reader, cycle, {});
  link.session().broadcast(biss::ControlCommand::control);
  while (!link.session().done()) {
    link.request();
    link.transfer_complete();
  }
  return port.held;
}
static_assert(ones_of_a_broadcast() == 6);

BISS_TEST(EncoderLink, ClockThatWrapsAround_ChangesNoBitOfAnAccess) {
  BISS_EXPECT_EQ(ones_of_a_broadcast(), 6U);
}

}  // namespace encoder_link_test
}  // namespace boards
