#include "firmware/boards/encoder_link.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "biss/frame/encode.hpp"
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

// A port that writes what the test says, or nothing.
struct WritingPort {
  std::span<std::uint8_t> receive{};

  constexpr bool start(std::span<std::uint8_t> into) {
    receive = into;
    return true;
  }
  constexpr void hold_ma_low() {}
  constexpr void answer(std::uint64_t position) {
    biss::BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.lead_clocks = 3;
    frame.ack_clocks = 5;
    frame.channel_list[0].position = position;
    const auto bits = biss::encode_frame(frame, reader.codec());
    std::fill(receive.begin(), receive.end(), std::uint8_t{0});
    std::copy_n(bits->bytes().begin(), bits->bytes().size(), receive.begin());
  }
};

using WritingLink = EncoderLink<WritingPort, decltype(reader), reader.bytes()>;

BISS_TEST(EncoderLink, TransferThatWritesNothing_IsNoResponse) {
  WritingPort port;
  WritingLink link(port, reader, biss::microseconds(100), {});
  link.request();
  port.answer(1234);
  link.transfer_complete();
  BISS_EXPECT(link.latest().trusted);
  BISS_EXPECT_EQ(link.latest().channel.position, 1234U);
  BISS_EXPECT_EQ(link.latest().request, 1U);
  for (std::uint32_t i = 1; i < 4; ++i) {
    link.request();
    link.transfer_complete();
    BISS_EXPECT(!link.latest().trusted);
    BISS_ASSERT(link.latest().fault);
    BISS_EXPECT_EQ(link.latest().fault->cause, biss::FrameError::no_response);
    BISS_EXPECT_EQ(link.counts().causes[biss::FrameError::no_response], i);
  }
}

BISS_TEST(EncoderLink, EndThatNothingWaitsFor_IsNoCycle) {
  WritingPort port;
  WritingLink link(port, reader, biss::microseconds(100), {});
  link.transfer_complete();
  link.request();
  port.answer(1234);
  link.transfer_complete();
  link.transfer_complete();
  link.transfer_failed();
  BISS_EXPECT_EQ(link.counts().cycles, 1U);
  BISS_EXPECT_EQ(link.counts().good, 1U);
  BISS_EXPECT_EQ(link.counts().unexpected, 3U);
  link.request();
  link.request();  // the end of the one before was never reported
  BISS_EXPECT_EQ(link.counts().unanswered, 1U);
}

// The end of one transfer is never reported: the access fails, and does not go on a bit off.
BISS_TEST(EncoderLink, RequestWithoutAnswer_EndsTheAccess) {
  WritingPort port;
  WritingLink link(port, reader, biss::microseconds(100), {});
  std::array<std::uint8_t, 1> byte{};
  link.session().read(0, 0x42, byte);
  for (int i = 0; i < 15; ++i) {
    link.request();
    port.answer(1234);
    link.transfer_complete();
  }
  BISS_EXPECT(!link.session().done());
  link.request();
  link.request();
  BISS_EXPECT(link.session().done());
  BISS_ASSERT(link.session().outcome().error);
  BISS_EXPECT_EQ(*link.session().outcome().error, biss::ControlError::frame_lost);
  BISS_EXPECT(!link.latest().trusted);
  BISS_EXPECT_EQ(link.latest().request, 16U);
}

BISS_TEST(EncoderLink, ReaderThatNeedsMoreThanTheBuffer_MakesNoRequest) {
  WritingPort port;
  EncoderLink<WritingPort, decltype(reader), reader.bytes() - 1> link(port, reader,
                                                                      biss::microseconds(100), {});
  link.request();
  link.transfer_complete();
  BISS_EXPECT(port.receive.empty());
  BISS_EXPECT_EQ(link.counts().late, 1U);
  BISS_EXPECT(!link.latest().trusted);
  BISS_EXPECT(link.error() == control_loop::AxisError::buffer);
}

// Which channel would be the position?
BISS_TEST(EncoderLink, FormatWithTwoChannels_MakesNoRequest) {
  constexpr biss::FrameFormat two = biss::frame_format("pos24,nE,nW,crc6+pos12,nE,nW,crc6");
  constexpr biss::SpiReader of_two{biss::FixedCodec<two>{}, {.period = biss::nanoseconds(200)}, {}};
  WritingPort port;
  EncoderLink<WritingPort, decltype(of_two), of_two.bytes()> link(port, of_two,
                                                                  biss::microseconds(100), {});
  link.request();
  BISS_EXPECT(port.receive.empty());
  BISS_EXPECT(link.error() == control_loop::AxisError::format);
  WritingLink good(port, reader, biss::microseconds(100), {});
  BISS_EXPECT(!good.error());
}

}  // namespace encoder_link_test
}  // namespace boards
