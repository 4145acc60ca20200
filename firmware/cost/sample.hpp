// The input of one measured call, prepared outside the measured time.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "biss/axis/axis.hpp"
#include "biss/base/bits.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/control/session.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/polled_read.hpp"
#include "biss/master/request.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/safety/configurations.hpp"
#include "biss/safety/monitor.hpp"
#include "biss/slave/banked_registers.hpp"
#include "biss/slave/register_server.hpp"
#include "biss/slave/slave.hpp"
#include "biss/turns/turn_counter.hpp"
#include "tests/core/monitor_bytes.hpp"

namespace cost {

inline constexpr biss::CatalogueEntry encoder = biss::catalogue_encoder("resolute-26");
inline constexpr biss::FrameFormat format = encoder.frame_format();
inline constexpr biss::SpiSetup setup{.period = biss::period_of(biss::megahertz(10)),
                                      .line_delay = {.max = biss::nanoseconds(700)}};

using Codec = biss::FrameCodec<biss::CrcFast, 1>;
using PlainCodec = biss::FrameCodec<biss::CrcBitwise, 1>;

/// An encoder with a given position.
struct Position {
  std::uint64_t value = 0;

  biss::BasicFrame<1> sample(biss::Picoseconds) const {
    biss::BasicFrame<1> frame;
    frame.channel_list[0].position = value;
    return frame;
  }
  bool cds(bool predecessor) const { return predecessor; }
  void cdm(bool) {}
};

using EncoderSlave = biss::Slave<biss::FixedCodec<format>, Position, 0>;

using EncoderServer = biss::RegisterServer<biss::BankedRegisters<2>>;

using EncoderMaster = biss::RequestCycle<biss::FixedCodec<format>>;

inline constexpr biss::MasterSetup master_setup{.period = setup.period, .timing = encoder.timing};
/// The line delay of the master's input; less than half a period.
inline constexpr biss::Picoseconds master_line_delay = biss::nanoseconds(20);

/// Pins whose SLO has the levels of `value`, and a clock that never lets MA wait.
struct Pins {
  static constexpr biss::Picoseconds time_step = biss::nanoseconds(10);
  std::uint32_t value = 0;
  biss::Picoseconds time{};

  void set_ma(bool) {}
  bool slo() {
    value = std::rotl(value, 1);
    return (value & 1U) != 0;
  }
  biss::Picoseconds now() { return time += biss::nanoseconds(600); }
};
inline constexpr biss::SpiSetup pins_setup{.period = biss::microseconds(1),
                                           .line_delay = {.max = biss::nanoseconds(700)},
                                           .max_pause = biss::microseconds(12)};
inline constexpr biss::DeviceTiming pins_timing{
    .timeout = {biss::TimeoutRule::fixed, biss::microseconds(20)}};

inline constexpr biss::FrameFormat safety_format =
    biss::safety_configuration("fs-36-28").frame_format();
inline constexpr biss::SafetySetup safety_setup = [] {
  biss::SafetySetup safety = biss::safety_configuration("fs-36-28").setup;
  // The next request begins only when SLO is high.
  safety.bounds = biss::spi_bounds(setup, biss::catalogue_encoder("fs-36-28").timing);
  safety.bounds.late_max_clocks = 0;
  return safety;
}();

using SafetyMonitor =
    biss::SafetyMonitor<biss::FixedSafetyPlan<safety_format, safety_setup, biss::CrcTable<8>>>;

/// Steps of up to half a turn. The first frame's time to power up is not over.
inline constexpr biss::AxisSetup axis_setup{
    .cycle = biss::nanoseconds(62'500),
    .to_sampling = biss::sampling_delay(setup, encoder.timing),
    .max_step = (1 << 20) - 1,
    .trip_after = 100};
/// The measured position, or the inverted cause.
constexpr std::uint64_t result_of(const biss::AxisPosition& position) {
  const bool measured = position.state == biss::AxisState::measured;
  return measured ? static_cast<std::uint64_t>(position.position)
                  : ~static_cast<std::uint64_t>(position.cause);
}

/// A sample begins with an earlier state.
using MonitorBytes = biss::test::MonitorBytes<SafetyMonitor>;

/// Two clocks, of which the second one started elsewhere.
constexpr biss::TwoClocks clocks_at(std::int64_t picoseconds) {
  return {biss::picoseconds(picoseconds), biss::picoseconds(picoseconds) + biss::milliseconds(7)};
}
/// Verdict and position in one number.
constexpr std::uint64_t result_of(const biss::SafetyJudgement& judgement) {
  const std::uint64_t value = judgement.position ? judgement.position->value : 0;
  return value << 16U | static_cast<std::uint64_t>(judgement.verdict);
}

struct Sample {
  std::array<std::uint8_t, 48> bytes{};
  std::uint32_t size_bytes = 0;
  std::uint32_t index = 0;
  std::uint64_t value = 0;
  /// Made at start-up from a format that the compiler cannot see.
  const biss::SpiReader<Codec>* reader = nullptr;
  Pins* pins = nullptr;
  biss::PolledRequest<Pins>* polled = nullptr;
  biss::TurnCounter* counter = nullptr;
  EncoderSlave* slave = nullptr;
  EncoderMaster* master = nullptr;
  biss::ControlSession* control = nullptr;
  EncoderServer* server = nullptr;
  SafetyMonitor* safety = nullptr;
  /// A monitor after its self test.
  const MonitorBytes* tested = nullptr;
  /// The position of the axis, with turns.
  std::int64_t position = 0;
  /// The expected result of the measured call.
  std::uint64_t expected = 0;

  std::span<const std::uint8_t> span() const {
    return std::span<const std::uint8_t>(bytes).first(size_bytes);
  }
  biss::BitView bits() const { return biss::BitView(span()); }
};

/// The position of a good frame, all ones of a bad one.
inline std::uint64_t position_of(const auto& frame) {
  return frame.ok() ? frame->channel_list[0].position : ~std::uint64_t{0};
}

}  // namespace cost
