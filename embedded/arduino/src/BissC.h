// Reads a BiSS C encoder with the SPI library of Arduino.
//
//   constexpr auto format = biss::frame_format("pos18,nE,nW,crc6");
//   constexpr biss::SpiSetup line{.period = biss::microseconds(1),
//                                 .line_delay = {.max = biss::microseconds(1)}};
//   BissReader<format, line> encoder(SPI);
//
//   void setup() { encoder.begin(); }
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

/// One encoder of this format on one SPI. A machine that moves has its own `Limits`, with the
/// largest step: they detect more wrong frames.
///
/// Some cores pause the clock between bytes. The encoder accepts that while a pause is shorter than
/// its timeout; see the notes for Arduino in docs/microcontrollers.md. A pause that is too long is
/// not detected here; biss::PolledRequest does it (example ReadWithoutSpi).
template <biss::FrameFormat Format, biss::SpiSetup Line,
          biss::DeviceTiming Timing = biss::DeviceTiming{},
          biss::AxisSetup Limits = biss_loop(Line, Timing)>
class BissReader {
  static constexpr biss::SpiReader reader{biss::FixedCodec<Format>{}, Line, Timing};
  static constexpr biss::AxisSetup limits = Limits;
  static_assert(!biss::check_axis(Limits, Format.channel_list[0].position_bits()));

 public:
  explicit BissReader(SPIClass& spi) : spi_{spi} {}

  /// Call it in setup().
  void begin() {
    spi_.library.begin();
    spi_.library.beginTransaction(spi_.settings());  // makes the idle level of SCK high
    spi_.library.endTransaction();
  }

  /// Requests a position and waits for it. Wait for the timeout of the encoder between two calls.
  /// \return a position, its state, and the cause if it was not measured now (docs/axis.md)
  biss::AxisPosition read() {
    axis_.request(clock_.now());
    axis_.transfer_complete();
    return axis_.position();
  }

  /// For reset(), turns and counts.
  auto& axis() { return axis_; }

 private:
  struct Spi {
    SPIClass& library;

    // The core may round the clock down, so choose one that it can make.
    static SPISettings settings() {
      return SPISettings(biss::rate_of(Line.period).count, MSBFIRST, SPI_MODE3);
    }
    bool start(std::span<std::uint8_t> receive) {
      library.beginTransaction(settings());
      library.transfer(receive.data(), receive.size());
      library.endTransaction();
      return true;
    }
  };

  Spi spi_;
  BissClock clock_;
  biss::EncoderAxis<Spi, decltype(reader), reader.bytes()> axis_{spi_, reader, limits};
};
