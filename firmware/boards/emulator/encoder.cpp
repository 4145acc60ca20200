// The encoder of firmware/encoder_maker at the end of a line, in WebAssembly: the emulators of the
// boards drive MA and receive SLO. Times are picoseconds and must not go backwards.
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "biss/base/units.hpp"
#include "firmware/encoder_maker/encoder.hpp"

namespace emulator {
namespace {

using biss::Picoseconds;

/// MA to SLO, both at the master.
constexpr Picoseconds line_delay = biss::nanoseconds(300);

/// Pins, clock and sensor of the encoder, and SLO on its way to the master.
class Board {
 public:
  constexpr Picoseconds now() const { return now_; }
  constexpr bool ma() const { return ma_; }
  constexpr void drive_slo(bool level) {
    if (level == slo_) return;
    slo_ = level;
    changes_[(first_ + count_++) % changes_.size()] = now_ + line_delay;
  }
  constexpr void set_alarm(Picoseconds at) { alarm_ = at; }
  /// A shaft at constant speed, one count in 1024 ns.
  constexpr std::uint32_t sensor(Picoseconds at) {
    sampled_ = static_cast<std::uint32_t>(at.count >> 20U) & 0xFF'FFFFU;
    return sampled_;
  }
  constexpr int temperature() const { return 23; }
  constexpr void mask_interrupts(bool) const {}
  constexpr void store_offset(std::uint32_t) const {}

  constexpr void set_time(Picoseconds now) { now_ = now; }
  constexpr void set_ma(bool level) { ma_ = level; }
  constexpr Picoseconds alarm() const { return alarm_; }
  constexpr std::uint32_t sampled() const { return sampled_; }
  /// SLO at the master.
  constexpr bool received(Picoseconds at) {
    while (count_ > 0 && changes_[first_ % changes_.size()] < at) {
      received_ = !received_;
      ++first_;
      --count_;
    }
    return received_;
  }

 private:
  Picoseconds now_{};
  Picoseconds alarm_ = biss::never;
  bool ma_ = true;
  bool slo_ = true;
  bool received_ = true;
  std::uint32_t sampled_ = 0;
  // The master samples once in a period, so that few changes are on the way.
  std::array<Picoseconds, 256> changes_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

constinit Board board;
constinit encoder_maker::Encoder<Board> encoder{board, 0, 0};

void run_until(Picoseconds time) {
  while (board.alarm() <= time) {
    board.set_time(board.alarm());
    encoder.step();
  }
  board.set_time(time);
  static_cast<void>(board.received(time - line_delay));
}

void drive_ma(Picoseconds time, bool level) {
  run_until(time);
  board.set_ma(level);
  encoder.step();
}

}  // namespace
}  // namespace emulator

extern "C" {

/// The encoder gets power. Call it first.
[[gnu::used, clang::export_name("power_on")]] void power_on(std::uint32_t serial_number) {
  std::construct_at(&emulator::encoder, emulator::board, serial_number, 0U);
}

/// MA changes to this level; the same level only lets time pass.
[[gnu::used, clang::export_name("drive_ma")]] void drive_ma(std::int64_t time, std::int32_t level) {
  emulator::drive_ma(biss::Picoseconds{time}, level != 0);
}

/// Eight clocks of an SPI in mode 3, the first falling edge at `time`. \return the received bits
[[gnu::used, clang::export_name("clock_byte")]] std::int32_t clock_byte(std::int64_t time,
                                                                        std::int64_t period) {
  std::int32_t byte = 0;
  for (int i = 0; i < 8; ++i, time += period) {
    emulator::drive_ma(biss::Picoseconds{time}, false);
    const biss::Picoseconds rise{time + period / 2};
    emulator::run_until(rise);
    byte = byte << 1U | (emulator::board.received(rise) ? 1 : 0);
    emulator::drive_ma(rise, true);
  }
  return byte;
}

/// The main loop of the encoder.
[[gnu::used, clang::export_name("do_ordered_work")]] void do_ordered_work() {
  emulator::encoder.do_ordered_work();
}

/// The count of the sensor that the last frame carries.
[[gnu::used, clang::export_name("sampled")]] std::uint32_t sampled() {
  return emulator::board.sampled();
}
}
