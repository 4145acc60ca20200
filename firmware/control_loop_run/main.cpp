// Runs the control loop of firmware/control_loop under QEMU and checks every cycle against the true
// position of the axis. SysTick is the control timer and, a quarter of a period later, the end of
// the SPI transfer.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "biss/base/units.hpp"
#include "firmware/control_loop/encoder_axis.hpp"
#include "firmware/control_loop_run/fake_spi.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"
#include "tests/core/random.hpp"

namespace control_loop_run {
namespace {

using control_loop::Quality;
using Reader = biss::SpiReader<Codec>;

constexpr Reader reader{codec, setup, encoder.timing};
constexpr control_loop::PolicyLimits limits{.rule = control_loop::BadFrameRule::extrapolate,
                                            .trip_after = 4,
                                            .max_step = Axis::top_speed + Axis::acceleration};

constexpr std::uint32_t cycles = 4000;
/// From here on the cable is unplugged; the loop has to trip on its fourth bad cycle.
constexpr std::uint32_t unplugged_from = cycles - 20;
constexpr std::uint64_t seed = 0xB155'100B;

constexpr biss::Picoseconds tick = biss::nanoseconds(31'250);
constexpr std::uint32_t ticks_a_period = 4;

struct Summary {
  std::uint32_t damaged = 0;
  std::uint32_t measured = 0;
  std::uint32_t extrapolated = 0;
  std::uint32_t held = 0;
  std::uint32_t none = 0;
  std::uint32_t tripped_at = 0;
  std::uint32_t wrong = 0;
  std::int64_t turns_most = 0;
  std::int64_t turns_least = 0;
  biss::Picoseconds oldest{};
};

struct Loop {
  FakeSpi spi;
  control_loop::EncoderAxis<FakeSpi, Reader, reader.bytes()> axis{spi, reader, ma_period,
                                                                  encoder.timing, limits};
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
  const bool room = loop.bad_in_a_row + 1U < limits.trip_after;
  if (!room || loop.random.below(6) != 0) return Damage::none;
  return static_cast<Damage>(1U + loop.random.below(5));
}

void expect(bool right, const char* what) {
  if (right) return;
  if (++loop.summary.wrong > 10) return;
  firmware::print("WRONG in cycle ", loop.cycle, ": ", what, "\n");
}

void check_measured(const control_loop::AxisPosition& latest, biss::Picoseconds now) {
  ++loop.summary.measured;
  expect(loop.bad_in_a_row == 0, "a damaged frame was taken");
  expect(latest.output.position == loop.truth.position, "the position differs from the axis");
  expect(loop.axis.turns().turns() == loop.truth.position >> 26, "the turns differ from the axis");
  // Half a clock to the first rising edge, 3.25 µs to the sampling moment.
  expect(latest.age(now) == tick * ticks_a_period - biss::nanoseconds(50 + 3'250), "age");
}

void check_extrapolated(const control_loop::AxisPosition& latest) {
  ++loop.summary.extrapolated;
  const std::int64_t n = latest.output.bad_in_a_row;
  const std::int64_t error = latest.output.position - loop.truth.position;
  // The speed changed once more for each cycle since it was measured, over up to trip_after cycles
  // before that.
  const std::int64_t most = Axis::acceleration * n * (n + limits.trip_after);
  expect(error <= most && error >= -most, "the extrapolation has a larger error than possible");
}

void check_period(biss::Picoseconds now) {
  const control_loop::AxisPosition& latest = loop.axis.latest();
  Summary& sum = loop.summary;
  expect(latest.output.quality == Quality::measured || loop.bad_in_a_row > 0,
         "a good frame was not taken");
  switch (latest.output.quality) {
    case Quality::measured:
      check_measured(latest, now);
      break;
    case Quality::extrapolated:
      check_extrapolated(latest);
      break;
    case Quality::held:
      ++sum.held;
      break;
    case Quality::none:
      ++sum.none;
      break;
    case Quality::tripped:
      if (sum.tripped_at == 0) sum.tripped_at = loop.cycle;
      break;
  }
  if (latest.output.quality != Quality::none && sum.tripped_at == 0 &&
      latest.age(now) > sum.oldest) {
    sum.oldest = latest.age(now);
  }
  const std::int64_t turns = loop.axis.turns().turns();
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
  print("cycles ", cycles, ", damaged ", sum.damaged, ": measured ", sum.measured,
        ", extrapolated ", sum.extrapolated, ", held ", sum.held, ", none yet ", sum.none);
  print("\ntripped in cycle ", sum.tripped_at, ", unplugged from ", unplugged_from + 1);
  print("\nturns -", static_cast<std::uint64_t>(-sum.turns_least), " to ",
        static_cast<std::uint64_t>(sum.turns_most), ", oldest position ",
        static_cast<std::uint64_t>(sum.oldest.count / 1000), " ns\ncauses:");
  const auto& causes = loop.axis.counts().causes;
  for (std::size_t i = 0; i < biss::frame_error_count; ++i) {
    const auto cause = static_cast<biss::FrameError>(i);
    if (causes[cause] != 0) print(" ", name_of(cause), " ", causes[cause]);
  }
  print("\n", sum.wrong, " wrong\n");
}

bool good(const Summary& sum) {
  return sum.wrong == 0 && sum.measured == cycles - sum.damaged && sum.extrapolated > 400 &&
         sum.none == 2 && sum.tripped_at == unplugged_from + limits.trip_after &&
         sum.turns_most > 0 && sum.turns_least < 0;
}

void start_timers() {
  auto* const systick = reinterpret_cast<volatile std::uint32_t*>(0xE000'E010U);
  *reinterpret_cast<volatile std::uint32_t*>(0xE000'E100U) = 1;  // NVIC_ISER0: interrupt 0
  systick[1] = static_cast<std::uint32_t>(BISS_BOARD_MHZ * tick.count / 1'000'000) - 1U;
  systick[2] = 0;
  systick[0] = 7;  // processor clock, interrupt, on
}

}  // namespace
}  // namespace control_loop_run

extern "C" void systick_handler() {
  using namespace control_loop_run;
  if (finished) return;
  const std::uint32_t phase = loop.ticks % ticks_a_period;
  if (phase == 0) control_period(tick * loop.ticks);
  if (phase == 1 && !finished) transfer_ends();
  ++loop.ticks;
}

extern "C" void dma_complete_handler() { control_loop_run::loop.axis.transfer_complete(); }

int firmware_main() {
  using namespace control_loop_run;
  start_timers();
  while (!finished) asm volatile("wfi");
  print_summary(loop.summary);
  return good(loop.summary) ? 0 : 1;
}
