// Reads a BiSS C encoder with the SPI library of Arduino.
//
//   constexpr auto format = biss::frame_format("pos18,nE,nW,crc6");
//   constexpr biss::SpiSetup line{.period = biss::microseconds(1),
//                                 .line_delay = {.max = biss::microseconds(1)}};
//   BissReader<format, line> encoder(SPI);
//
//   void setup() { SPI.begin(), encoder.begin(); }
//   void loop() {
//     const biss::AxisPosition now = encoder.read();
//     if (now.state == biss::AxisState::measured) use(now.position);
//     if (now.state == biss::AxisState::tripped) encoder.axis().reset();
//   }
//
// SCK is MA, MISO (CIPO) is SLO, each through an RS-422 driver or receiver. Include this header
// before other headers of the core.
#pragma once

#if __cplusplus < 202002L
#error "BissC needs C++20: add -std=gnu++20 to the flags of the compiler (platform.local.txt)"
#endif

#include <Arduino.h>
#include <SPI.h>

// First, because the C++ library does not compile with Arduino's macros min and max.
#include "biss/base/language.hpp"

#include <cstdint>
#include <span>
#include <utility>

#include "biss/axis/encoder_axis.hpp"
#include "biss/base/units.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/polled_read.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

/// A clock for an axis. micros() returns to 0 after 71 minutes; millis() has the time above that.
class BissClock {
 public:
  /// Wraps around at the limits of its type. Call it at least once in 49 days.
  biss::Picoseconds now() {
    milliseconds_ += static_cast<std::uint32_t>(millis() - milliseconds_);
    const std::uint64_t coarse = milliseconds_ * 1'000U;
    const std::int64_t rest =
        static_cast<std::int32_t>(static_cast<std::uint32_t>(micros() - coarse));
    const std::uint64_t microseconds = coarse + static_cast<std::uint64_t>(rest);
    return biss::Picoseconds{static_cast<std::int64_t>(microseconds * 1'000'000U)};
  }

 private:
  std::uint64_t milliseconds_ = 0;
};

/// The limits of an axis in a loop: less than half a turn from one reading to the next, and at most
/// a second. A bad reading holds the position, and the fourth in a row trips.
constexpr biss::AxisSetup biss_loop(const biss::SpiSetup& line, const biss::DeviceTiming& timing) {
  return {.cycle = biss::milliseconds(1'000),
          .to_sampling = biss::sampling_delay(line, timing),
          .max_step = biss::no_step_limit,
          .bad_cycles = biss::BadCycleRule::hold};
}

/// The SPI library as the SPI of an axis. The core may round the clock of MA down, so choose one that
/// it can make.
class BissSpi {
 public:
  BissSpi(SPIClass& spi, const biss::SpiSetup& line, const biss::DeviceTiming&)
      : spi_(spi), settings_(biss::rate_of(line.period).count, MSBFIRST, SPI_MODE3) {}

  bool start(std::span<std::uint8_t> receive) {
    spi_.beginTransaction(settings_);
    if (!receive.empty()) spi_.transfer(receive.data(), receive.size());
    spi_.endTransaction();
    return true;
  }
  biss::PolledState step() { return biss::PolledState::complete; }

 private:
  SPIClass& spi_;
  SPISettings settings_;
};

/// One encoder of this format on an SPI, or on two pins: `Board` is a PolledPins of polled_read.hpp
/// (example ReadWithoutSpi). A machine that moves has its own `Limits`, with the largest step: they
/// detect more wrong frames.
///
/// Some cores pause the clock of an SPI between bytes. The encoder accepts that while a pause is
/// shorter than its timeout; see the notes for Arduino in docs/microcontrollers.md. A pause that is
/// too long is detected only with pins.
template <biss::FrameFormat Format, biss::SpiSetup Line, class Board = SPIClass,
          biss::DeviceTiming Timing = biss::DeviceTiming{},
          biss::AxisSetup Limits = biss_loop(Line, Timing)>
class BissReader {
  static constexpr biss::SpiReader reader{biss::FixedCodec<Format>{}, Line, Timing};
  static constexpr biss::AxisSetup limits = Limits;
  static_assert(Format.channel_count == 1, "one encoder");
  static_assert(!biss::check_axis(Limits, Format.channel_list[0].position_bits()), "AxisError");

  static auto requests_of(SPIClass& spi) { return BissSpi(spi, Line, Timing); }
  template <biss::PolledPins Pins>
  static auto requests_of(Pins& pins) {
    return biss::PolledRequest(pins, Line, Timing);
  }
  using Requests = decltype(requests_of(std::declval<Board&>()));

 public:
  explicit BissReader(Board& board) : requests_(requests_of(board)) {}

  /// Makes the idle level of an SPI's clock high. Call it in setup(), after SPI.begin().
  void begin() { requests_.start({}); }

  /// Requests a position and waits for it. Wait for the timeout of the encoder between two calls.
  /// \return a position, its state, and the cause if it was not measured now (docs/axis.md)
  biss::AxisPosition read() {
    axis_.request(clock_.now());
    biss::PolledState state = requests_.step();
    while (state == biss::PolledState::running) state = requests_.step();
    if (state == biss::PolledState::complete) {
      axis_.transfer_complete();
    } else {
      axis_.transfer_failed();
    }
    return axis_.position();
  }

  /// For reset(), turns and counts.
  auto& axis() { return axis_; }

 private:
  BissClock clock_;
  Requests requests_;
  biss::EncoderAxis<Requests, decltype(reader), reader.bytes()> axis_{requests_, reader, limits};
};
