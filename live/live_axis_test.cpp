// The axes of a live line: positions of one channel and of a chain, failed transfers, formats that
// cannot be read.
#include "live/live_axis.hpp"

#include <gtest/gtest.h>

#include "biss/frame/codec.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::live_axis_test {

using live::LiveAxis;

constexpr SpiSetup spi{.period = microseconds(1)};
constexpr AxisSetup setup{.cycle = milliseconds(1),
                          .to_sampling = microseconds(1),
                          .max_step = 128,
                          .bad_cycles = BadCycleRule::hold,
                          .trip_after = 40};
constexpr std::array setups{setup, setup};

FrameFormat format_of(const char* text) { return *parse_format(text); }

std::vector<std::uint8_t> answer(const FrameFormat& format, std::vector<std::uint64_t> positions,
                                 std::size_t bytes) {
  Frame frame;
  frame.channel_count = static_cast<std::uint8_t>(positions.size());
  frame.lead_clocks = 2;
  frame.ack_clocks = 3;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    frame.channel_list[k].position = positions[k];
  }
  const auto bits = encode_frame(frame, FrameCodec<>(format));
  std::vector<std::uint8_t> out(bytes);
  for (std::size_t i = 0; i < bits->size_bits(); ++i) {
    if (bits->view()[i]) out[i / 8] |= static_cast<std::uint8_t>(0x80U >> (i % 8));
  }
  return out;
}

TEST(LiveAxis, PositionsOfAChain) {
  const FrameFormat format = format_of("pos12,nE,nW,crc6+pos20,nE,nW,crc6");
  const auto axis = LiveAxis::make(format, {}, spi, setups);
  ASSERT_TRUE(axis) << axis.error();
  ASSERT_EQ((*axis)->axes(), 2U);
  for (int i = 0; i < 3; ++i) {
    (*axis)->take(milliseconds(i), answer(format, {100, 70'000}, (*axis)->bytes()));
  }
  EXPECT_EQ((*axis)->position(0).position, 100);
  EXPECT_EQ((*axis)->position(1).position, 70'000);
  EXPECT_EQ((*axis)->position(1).state, AxisState::measured);
  (*axis)->take(milliseconds(3), {});
  EXPECT_EQ((*axis)->position(1).cause, AxisCause::failed);
  EXPECT_EQ((*axis)->count(0, AxisCause::failed), 1U);
  EXPECT_EQ((*axis)->count(0, AxisCause::ok), 2U);
}

TEST(LiveAxis, ABufferOfTheLastFrameThatIsCutOff) {
  const FrameFormat format = format_of("pos12,nE,nW,crc6");
  const auto axis = LiveAxis::make(format, {}, spi, setups);
  ASSERT_TRUE(axis);
  const auto whole = answer(format, {100}, (*axis)->bytes());
  for (int i = 0; i < 3; ++i) (*axis)->take(milliseconds(i), whole);
  (*axis)->take(milliseconds(3), std::span(whole).first(1));
  EXPECT_NE((*axis)->position(0).cause, AxisCause::ok);
}

TEST(LiveAxis, OneBadCycleKeepsTheTurns) {
  const FrameFormat format = format_of("pos12,nE,nW,crc6");
  const auto axis = LiveAxis::make(format, {}, spi, setups);
  ASSERT_TRUE(axis);
  int now = 0;
  const auto take = [&](std::uint64_t position) {
    (*axis)->take(milliseconds(now++), answer(format, {position}, (*axis)->bytes()));
  };
  for (const std::uint64_t position : {4'000U, 4'090U, 60U}) take(position);
  (*axis)->take(milliseconds(now++), {});
  take(100);
  EXPECT_EQ((*axis)->position(0).position, 4'096 + 100);
  EXPECT_EQ((*axis)->position(0).state, AxisState::measured);
  EXPECT_EQ((*axis)->frame()->channel_list[0].position, 100U);
  EXPECT_EQ((*axis)->frame()->ack_clocks, 3);
  EXPECT_EQ((*axis)->frame()->lead_clocks, 2);
}

TEST(LiveAxis, LostTurnsAndATrip_StartAgain) {
  const FrameFormat format = format_of("pos12,nE,nW,crc6");
  for (const int bad : {20, 100}) {
    const auto axis = LiveAxis::make(format, {}, spi, setups);
    ASSERT_TRUE(axis);
    const auto good = answer(format, {100}, (*axis)->bytes());
    int now = 0;
    for (int i = 0; i < 3; ++i) (*axis)->take(milliseconds(now++), good);
    for (int i = 0; i < bad; ++i) (*axis)->take(milliseconds(now++), {});
    for (int i = 0; i < 4; ++i) (*axis)->take(milliseconds(now++), good);
    EXPECT_EQ((*axis)->position(0).state, AxisState::measured) << bad;
    EXPECT_EQ((*axis)->position(0).position, 100) << bad;
    EXPECT_EQ((*axis)->count(0, AxisCause::failed), static_cast<std::uint32_t>(bad)) << bad;
  }
}

TEST(LiveAxis, FormatsWithoutAPositionAreRefused) {
  const auto axis = LiveAxis::make(format_of("pad12,nE,crc6"), {}, spi, setups);
  ASSERT_FALSE(axis);
  EXPECT_EQ(axis.error(), "a channel has no position of 1 to 62 bits");
}

}  // namespace biss::live_axis_test
