// Runs an axis with interrupts under QEMU and checks every cycle against the true position. SysTick
// is the control timer and, a quarter of a period later, the end of the SPI transfer.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/axis/encoder_axis.hpp"
#include "biss/base/units.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/encode.hpp"
#include "biss/master/spi_read.hpp"
#include "firmware/boards/cortex_m.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"
#include "tests/core/random.hpp"

namespace axis_run {
namespace {

// ---- A model of an SPI peripheral with DMA and an encoder: QEMU has none that could read a BiSS
// frame. The axis turns back and forth across zero, and the line is damaged.

constexpr biss::CatalogueEntry encoder = biss::catalogue_encoder("resolute-26");
constexpr biss::Picoseconds ma_period = biss::period_of(biss::megahertz(10));
constexpr biss::SpiSetup setup{.period = ma_period, .line_delay = {.max = biss::nanoseconds(700)}};
using Codec = biss::FrameCodec<biss::CrcFast, 1>;
constexpr Codec codec{encoder.frame_format()};

/// The damage to a cycle on the line.
enum class Damage : std::uint8_t {
  none,
  flips,      ///< one or two bits of data and CRC
  pulled,     ///< SLO goes high in the middle of the data and stays
  unplugged,  ///< SLO is high throughout
  stuck_low,  ///< SLO is low throughout
  error_bit,  ///< a good frame with nE = 0
};

/// The axis: its speed changes by `acceleration` a cycle, up and down between plus and minus
/// `top_speed` counts a cycle.
struct Axis {
  static constexpr std::int64_t top_speed = 1'500'000;
  static constexpr std::int64_t acceleration = 4'000;

  /// Far enough from zero that the first sample is in turn 0, in which counting begins.
  std::int64_t position = 5'000'000;
  std::int64_t speed = -top_speed / 2;
  bool upwards = true;

  void step() {
    position += speed;
    speed += upwards ? acceleration : -acceleration;
    if (speed >= top_speed) upwards = false;
    if (speed <= -top_speed) upwards = true;
  }
};

constexpr unsigned word_bits = codec.payload_bits();

// The frame, except for the damage to a whole cycle.
biss::FrameBits answer(const Axis& axis, Damage damage, biss::test::Random& random) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + random.below(5));
  frame.ack_clocks = static_cast<std::uint16_t>(33U + random.below(100));
  frame.channel_list[0].position = static_cast<std::uint64_t>(axis.position) & biss::low_mask(26);
  frame.channel_list[0].nE = damage != Damage::error_bit;
  auto bits = biss::encode_frame(frame, codec).value();
  const std::size_t first = bits.size_bits() - 2U - random.below(word_bits);
  const std::size_t second = bits.size_bits() - 2U - random.below(word_bits);
  if (damage == Damage::flips) bits.flip(first);
  if (damage == Damage::flips && second != first) bits.flip(second);
  if (damage == Damage::pulled) {
    bits.truncate(first);
    bits.append_run(true, 400);
  }
  return bits;
}

class FakeSpi {
 public:
  /// Implements the concept SpiDma.
  bool start(std::span<std::uint8_t> receive) {
    if (!receive_.empty()) return false;
    receive_ = receive;
    return true;
  }

  /// The hardware's part: answers the request, writes the buffer, raises the DMA interrupt. Nothing
  /// happens without a request.
  void finish_transfer(const Axis& axis, Damage damage, biss::test::Random& random) {
    if (receive_.empty()) return;
    const biss::FrameBits bits = answer(axis, damage, random);
    const auto bytes = bits.bytes().first(std::min(bits.bytes().size(), receive_.size()));
    const std::uint8_t rest = damage == Damage::unplugged ? 0xFF : 0;
    std::fill(receive_.begin(), receive_.end(), rest);
    const bool answers = damage != Damage::unplugged && damage != Damage::stuck_low;
    if (answers) std::copy(bytes.begin(), bytes.end(), receive_.begin());
    receive_ = {};
    // In place of the DMA controller, software pends its interrupt (NVIC_ISPR0).
    boards::at(0xE000'E200U) = 1;
  }

 private:
  std::span<std::uint8_t> receive_{};
};

// ---- The loop

using State = biss::AxisState;
using Reader = biss::SpiReader<Codec>;

constexpr Reader reader{codec, setup, encoder.timing};

constexpr std::uint32_t cycles = 4000;
constexpr std::uint32_t first_measured = 4;
/// From here on the cable is unplugged; the loop has to trip on its fourth bad cycle.
constexpr std::uint32_t unplugged_from = cycles - 20;
constexpr std::uint64_t seed = 0xB155'100B;

constexpr biss::Picoseconds tick = biss::nanoseconds(31'250);
constexpr std::uint32_t ticks_a_period = 4;
constexpr biss::AxisSetup axis_setup{.cycle = tick * ticks_a_period,
                                     .to_sampling = biss::sampling_delay(setup, encoder.timing),
                                     .max_step = Axis::top_speed + Axis::acceleration,
                                     .trip_after = 4};

struct Loop {
  FakeSpi spi;
  biss::EncoderAxis<FakeSpi, Reader, reader.bytes()> axis{spi, reader, axis_setup};
  Axis truth;
  biss::test::Random random{seed};
  std::uint32_t ticks = 0;
  std::uint32_t cycle = 0;
  std::uint32_t bad_in_a_row = 0;
  std::uint32_t damaged = 0;
  std::uint32_t wrong = 0;
  std::int64_t turns_most = 0;
  std::int64_t turns_least = 0;
};

// Constant-initialised, like everything that lives before firmware_main().
constinit Loop loop;
volatile bool finished = false;

Damage next_damage() {
  if (loop.cycle >= unplugged_from) return Damage::unplugged;
  // The first cycles find the encoder still starting up.
  if (loop.cycle < 2) return Damage::stuck_low;
  // Two frames in a row are the first position.
  if (loop.cycle < first_measured) return Damage::none;
  const bool room = loop.bad_in_a_row + 1U < axis_setup.trip_after;
  if (!room || loop.random.below(6) != 0) return Damage::none;
  return static_cast<Damage>(1U + loop.random.below(5));
}

void expect(bool right, const char* what) {
  if (right) return;
  if (++loop.wrong > 10) return;
  firmware::print("WRONG in cycle ", loop.cycle, ": ", what, "\n");
}

// The encoder has started, two good frames have agreed, and no fault lasts for trip_after cycles but
// the last one.
State expected_state() {
  if (loop.cycle < first_measured) return State::no_position;
  if (loop.bad_in_a_row == 0) return State::measured;
  return loop.bad_in_a_row < axis_setup.trip_after ? State::extrapolated : State::tripped;
}

void check_measured(const biss::AxisPosition& latest, biss::Picoseconds now) {
  expect(latest.position == loop.truth.position, "the position differs from the axis");
  expect(loop.axis.axis().turns() == loop.truth.position >> 26, "the turns differ from the axis");
  // Half a clock to the first rising edge, 3.25 µs to the sampling moment.
  expect(latest.age(now) == tick * ticks_a_period - biss::nanoseconds(50 + 3'250), "age");
}

void check_extrapolated(const biss::AxisPosition& latest) {
  const std::int64_t n = latest.bad_in_a_row;
  const std::int64_t error = latest.position - loop.truth.position;
  // The speed changed once more for each cycle since it was measured, over up to trip_after cycles
  // before that.
  const std::int64_t most = Axis::acceleration * n * (n + axis_setup.trip_after);
  expect(error <= most && error >= -most, "the extrapolation has a larger error than possible");
}

void check_period(biss::Picoseconds now) {
  const biss::AxisPosition latest = loop.axis.position();
  expect(latest.state == expected_state(), "the state");
  if (latest.state == State::measured) check_measured(latest, now);
  if (latest.state == State::extrapolated) check_extrapolated(latest);
  const std::int64_t turns = loop.axis.axis().turns();
  loop.turns_most = std::max(loop.turns_most, turns);
  loop.turns_least = std::min(loop.turns_least, turns);
}

// The control interrupt of a drive: uses the position, requests the next one.
void control_period(biss::Picoseconds now) {
  if (loop.cycle > 0) check_period(now);
  if (loop.cycle == cycles) {
    finished = true;
    return;
  }
  loop.axis.request(now);
}

// The end of a transfer, as the hardware reports it.
void transfer_ends() {
  loop.truth.step();
  const Damage damage = next_damage();
  loop.bad_in_a_row = damage == Damage::none ? 0 : loop.bad_in_a_row + 1;
  if (damage != Damage::none) ++loop.damaged;
  ++loop.cycle;
  loop.spi.finish_transfer(loop.truth, damage, loop.random);
}

void print_summary() {
  using firmware::print;
  print("cycles ", cycles, ", damaged ", loop.damaged, ", turns -",
        static_cast<std::uint64_t>(-loop.turns_least), " to ",
        static_cast<std::uint64_t>(loop.turns_most), "\ncauses:");
  for (std::size_t i = 0; i < biss::axis_cause_count; ++i) {
    const auto cause = static_cast<biss::AxisCause>(i);
    const std::uint32_t count = loop.axis.axis().counts()[cause];
    if (count != 0) print(" ", name_of(cause), " ", count);
  }
  print("\n", loop.wrong, " wrong\n");
}

bool good() {
  return loop.wrong == 0 && loop.turns_most > 0 && loop.turns_least < 0 && loop.damaged > 400 &&
         loop.axis.axis().counts()[biss::AxisCause::ok] == cycles - loop.damaged - 1;
}

}  // namespace
}  // namespace axis_run

extern "C" void systick_handler() {
  using namespace axis_run;
  if (finished) return;
  const std::uint32_t phase = loop.ticks % ticks_a_period;
  if (phase == 0) control_period(tick * loop.ticks);
  if (phase == 1 && !finished) transfer_ends();
  ++loop.ticks;
}

extern "C" void dma_complete_handler() { axis_run::loop.axis.transfer_complete(); }

int firmware_main() {
  using namespace axis_run;
  boards::enable_interrupt(0);
  boards::start_cycle_timer(static_cast<std::uint32_t>(BISS_BOARD_MHZ * tick.count / 1'000'000));
  while (!finished) boards::wait_for_interrupt();
  print_summary();
  return good() ? 0 : 1;
}
