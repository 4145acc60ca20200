// Runs an axis with interrupts under QEMU and checks every cycle against the true position. SysTick
// is the control timer and, a quarter of a period later, the end of the SPI transfer.
#include <algorithm>
#include <array>
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

biss::FrameBits answer(const Axis& axis, Damage damage, std::uint64_t random) {
  biss::Frame frame;
  frame.channel_count = 1;
  frame.lead_clocks = static_cast<std::uint16_t>(2U + random % 5U);
  frame.ack_clocks = static_cast<std::uint16_t>(33U + (random >> 8U) % 100U);
  frame.channel_list[0].position = static_cast<std::uint64_t>(axis.position) & biss::low_mask(26);
  frame.channel_list[0].nE = damage != Damage::error_bit;
  return biss::encode_frame(frame, codec).value();
}

void spoil(biss::FrameBits& bits, Damage damage, std::uint64_t random) {
  const std::size_t word = bits.size_bits() - 1U - word_bits;
  const auto first = static_cast<std::size_t>((random >> 16U) % word_bits);
  const auto second = static_cast<std::size_t>((random >> 24U) % word_bits);
  if (damage == Damage::flips) {
    bits.flip(word + first);
    if (second != first) bits.flip(word + second);
  }
  if (damage == Damage::pulled) {
    bits.truncate(word + first);
    bits.append_run(true, 400);
  }
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
  void finish_transfer(const Axis& axis, Damage damage, std::uint64_t random) {
    if (receive_.empty()) return;
    auto bits = answer(axis, damage, random);
    spoil(bits, damage, random);
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

struct Summary {
  std::uint32_t damaged = 0;
  /// Cycles in each state.
  std::array<std::uint32_t, biss::axis_state_names.size()> with{};
  std::uint32_t tripped_at = 0;
  std::uint32_t wrong = 0;
  std::int64_t turns_most = 0;
  std::int64_t turns_least = 0;
  biss::Picoseconds oldest{};

  std::uint32_t& operator[](State state) { return with[static_cast<std::size_t>(state)]; }
  std::uint32_t operator[](State state) const { return with[static_cast<std::size_t>(state)]; }
};

struct Loop {
  FakeSpi spi;
  biss::EncoderAxis<FakeSpi, Reader, reader.bytes()> axis{spi, reader, axis_setup};
  Axis truth;
  biss::test::Random random{seed};
  Summary summary;
  std::uint32_t ticks = 0;
  std::uint32_t cycle = 0;
  std::uint32_t bad_in_a_row = 0;
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
  if (++loop.summary.wrong > 10) return;
  firmware::print("WRONG in cycle ", loop.cycle, ": ", what, "\n");
}

void check_measured(const biss::AxisPosition& latest, biss::Picoseconds now) {
  expect(loop.bad_in_a_row == 0, "a damaged frame was taken");
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
  Summary& sum = loop.summary;
  expect(latest.state == State::measured || loop.bad_in_a_row > 0 || loop.cycle < first_measured,
         "a good frame was not taken");
  ++sum[latest.state];
  if (latest.state == State::measured) check_measured(latest, now);
  if (latest.state == State::extrapolated) check_extrapolated(latest);
  if (latest.state == State::tripped && sum.tripped_at == 0) sum.tripped_at = loop.cycle;
  if (latest.state != State::no_position && sum.tripped_at == 0 && latest.age(now) > sum.oldest) {
    sum.oldest = latest.age(now);
  }
  const std::int64_t turns = loop.axis.axis().turns();
  sum.turns_most = std::max(sum.turns_most, turns);
  sum.turns_least = std::min(sum.turns_least, turns);
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
  if (damage != Damage::none) ++loop.summary.damaged;
  ++loop.cycle;
  loop.spi.finish_transfer(loop.truth, damage, loop.random.next());
}

void print_summary(const Summary& sum) {
  using firmware::print;
  print("cycles ", cycles, ", damaged ", sum.damaged, ": measured ", sum[State::measured],
        ", extrapolated ", sum[State::extrapolated], ", held ", sum[State::held], ", none yet ",
        sum[State::no_position]);
  print("\ntripped in cycle ", sum.tripped_at, ", unplugged from ", unplugged_from + 1);
  print("\nturns -", static_cast<std::uint64_t>(-sum.turns_least), " to ",
        static_cast<std::uint64_t>(sum.turns_most), ", oldest position ",
        static_cast<std::uint64_t>(sum.oldest.count / 1000), " ns\ncauses:");
  for (std::size_t i = 1; i < biss::axis_cause_count; ++i) {
    const auto cause = static_cast<biss::AxisCause>(i);
    const std::uint32_t count = loop.axis.axis().counts()[cause];
    if (count != 0) print(" ", name_of(cause), " ", count);
  }
  print("\n", sum.wrong, " wrong\n");
}

bool good(const Summary& sum) {
  return sum.wrong == 0 && sum[State::measured] == cycles - sum.damaged - 1 &&
         sum[State::extrapolated] > 400 && sum[State::no_position] == 3 &&
         sum.tripped_at == unplugged_from + axis_setup.trip_after && sum.turns_most > 0 &&
         sum.turns_least < 0;
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
  print_summary(loop.summary);
  return good(loop.summary) ? 0 : 1;
}
