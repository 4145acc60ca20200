#include "biss/axis/encoder_link.hpp"

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

namespace biss::encoder_link_test {

constexpr FrameFormat format = frame_format("pos24,nE,nW,crc6");
constexpr SpiReader reader{
    FixedCodec<format>{}, {.period = nanoseconds(200)}, DeviceTiming{.ack_max = microseconds(2)}};

constexpr AxisSetup setup{
    .cycle = microseconds(100), .to_sampling = microseconds(1), .max_step = no_step_limit};

// Every transfer ends at once, with SLO low throughout.
struct Port {
  constexpr bool start(std::span<std::uint8_t>) { return true; }
  constexpr void hold_ma_low() { ++held; }

  std::uint32_t held = 0;
};

// The bits of CDM that are 1 in a broadcast. The clock wraps around in every fourth cycle.
constexpr std::uint32_t ones_of_a_broadcast() {
  Port port;
  EncoderLink<Port, decltype(reader), reader.bytes()> link(port, reader, setup, {});
  link.session().broadcast(ControlCommand::control);
  const Picoseconds cycle{std::numeric_limits<std::int64_t>::max() / 2};
  for (Picoseconds now{}; !link.session().done(); now = wrapping_later(now, cycle)) {
    link.request(now);
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
    BasicFrame<1> frame;
    frame.channel_count = 1;
    frame.lead_clocks = 3;
    frame.ack_clocks = 5;
    frame.channel_list[0].position = position;
    const auto bits = encode_frame(frame, reader.codec());
    std::fill(receive.begin(), receive.end(), std::uint8_t{0});
    std::copy_n(bits->bytes().begin(), bits->bytes().size(), receive.begin());
  }
};

using WritingLink = EncoderLink<WritingPort, decltype(reader), reader.bytes()>;

struct Link {
  WritingPort port{};
  EncoderLink<WritingPort, decltype(reader), reader.bytes()> link{port, reader, setup, {}};
  Picoseconds now{};

  void request() { link.request(now += setup.cycle); }
  void answer(std::uint64_t position) {
    request();
    port.answer(position);
    link.transfer_complete();
  }
  std::uint32_t count(AxisCause cause) const { return link.axis().axis().counts()[cause]; }
};

BISS_TEST(EncoderLink, TransferThatWritesNothing_IsNoResponse) {
  Link a;
  a.answer(1234);
  a.answer(1234);
  BISS_EXPECT_EQ(a.link.axis().position().state, AxisState::measured);
  BISS_EXPECT_EQ(a.link.axis().position().position, 1234);
  BISS_EXPECT_EQ(a.link.axis().position().number, 2U);
  for (std::uint32_t i = 1; i < 4; ++i) {
    a.request();
    a.link.transfer_complete();
    BISS_EXPECT_EQ(a.link.axis().position().state, AxisState::extrapolated);
    BISS_EXPECT_EQ(a.link.axis().position().cause, AxisCause::no_response);
    BISS_EXPECT_EQ(a.count(AxisCause::no_response), i);
  }
}

BISS_TEST(EncoderLink, EndThatNothingWaitsFor_IsNoCycle) {
  Link a;
  a.link.transfer_complete();
  a.answer(1234);
  a.link.transfer_complete();
  a.link.transfer_failed();
  BISS_EXPECT_EQ(a.count(AxisCause::first), 1U);
  BISS_EXPECT_EQ(a.count(AxisCause::unexpected), 3U);
  a.request();
  a.request();  // the end of the one before was never reported
  BISS_EXPECT_EQ(a.count(AxisCause::unanswered), 1U);
}

// The end of one transfer is never reported: the access fails, and does not go on a bit off.
BISS_TEST(EncoderLink, RequestWithoutAnswer_EndsTheAccess) {
  Link a;
  std::array<std::uint8_t, 1> byte{};
  a.link.session().read(0, 0x42, byte);
  for (int i = 0; i < 15; ++i) a.answer(1234);
  BISS_EXPECT(!a.link.session().done());
  a.request();
  a.request();
  BISS_EXPECT(a.link.session().done());
  BISS_ASSERT(a.link.session().outcome().error);
  BISS_EXPECT_EQ(*a.link.session().outcome().error, ControlError::frame_lost);
  BISS_EXPECT_EQ(a.link.axis().position().cause, AxisCause::unanswered);
  BISS_EXPECT_EQ(a.link.axis().position().number, 15U);
}

// The encoder has seen the frame of a request that a reset gives up.
BISS_TEST(EncoderLink, ResetOfTheAxisWhileARequestRuns_EndsTheAccess) {
  Link a;
  std::array<std::uint8_t, 1> byte{};
  a.link.session().read(0, 0x42, byte);
  for (int i = 0; i < 15; ++i) a.answer(1234);
  a.request();
  a.link.axis().reset();
  a.link.transfer_complete();
  BISS_EXPECT(!a.link.session().done());
  a.answer(1234);
  BISS_EXPECT(a.link.session().done());
  BISS_EXPECT(a.link.session().outcome().error == ControlError::frame_lost);
}

// Readers and setups that are gone after the statement.
using Reader = std::remove_cvref_t<decltype(reader)>;
static_assert(!std::is_constructible_v<EncoderLink<WritingPort, Reader, reader.bytes()>,
                                       WritingPort&, Reader, const AxisSetup&, ControlOptions>);
static_assert(!std::is_constructible_v<EncoderLink<WritingPort, Reader, reader.bytes()>,
                                       WritingPort&, const Reader&, AxisSetup, ControlOptions>);

BISS_TEST(EncoderLink, ReaderThatNeedsMoreThanTheBuffer_MakesNoRequest) {
  WritingPort port;
  EncoderLink<WritingPort, decltype(reader), reader.bytes() - 1> link(port, reader, setup, {});
  link.request({});
  link.transfer_complete();
  BISS_EXPECT(port.receive.empty());
  BISS_EXPECT_EQ(link.axis().position().state, AxisState::tripped);
  BISS_EXPECT(link.axis().error() == AxisError::buffer);
}

// Which channel would be the position?
BISS_TEST(EncoderLink, FormatWithTwoChannels_NeedsTwoAxes) {
  constexpr FrameFormat two = frame_format("pos24,nE,nW,crc6+pos12,nE,nW,crc6");
  static constexpr SpiReader of_two{FixedCodec<two>{}, {.period = nanoseconds(200)}, {}};
  WritingPort port;
  EncoderLink<WritingPort, decltype(of_two), of_two.bytes()> link(port, of_two, setup, {});
  link.request({});
  BISS_EXPECT(port.receive.empty());
  BISS_EXPECT(link.axis().error() == AxisError::format);
  EncoderLink<WritingPort, decltype(of_two), of_two.bytes(), 2> good(port, of_two, setup, {});
  BISS_EXPECT(!good.axis().error());
}

}  // namespace biss::encoder_link_test
