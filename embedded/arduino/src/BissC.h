// Reads a BiSS C encoder with the SPI library of Arduino.
//
//   constexpr auto format = biss::frame_format("pos18,nE,nW,crc6");
//   BissReader<format> encoder(SPI, 1000000);
//
//   void setup() { encoder.begin(); }
//   void loop() {
//     const auto reading = encoder.read();
//     if (reading.trusted()) use(reading.position);
//   }
//
// SCK is MA, MISO (CIPO) is SLO, each through an RS-422 driver or receiver.
#pragma once

#if __cplusplus < 202002L
#error "BissC needs C++20: add -std=gnu++20 to the flags of the compiler (platform.local.txt)"
#endif

#include <Arduino.h>
#include <SPI.h>

#include <array>
#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/polled_read.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

/// The result of one request: the position of the first channel, or the cause why there is none.
struct BissReading {
  std::uint64_t position = 0;
  /// The encoder reports: false = error, false = warning.
  bool nE = false;
  bool nW = false;
  std::optional<biss::FrameFault> fault{};

  /// The position may be used.
  bool trusted() const { return !fault && nE; }
  /// Why the position may not be used: the name of the cause, or "encoder error" if nE is 0. "ok"
  /// if it may be used.
  const char* cause() const {
    if (fault) return biss::name_of(fault->cause).data();
    return nE ? "ok" : "encoder error";
  }
};

/// One encoder of this format on one SPI.
///
/// Some cores pause the clock between bytes. The encoder accepts that while a pause is shorter than
/// its timeout; see the notes for Arduino in docs/microcontrollers.md. A pause that is too long is
/// not detected here; biss::PolledRequest does it (example ReadWithoutSpi).
///
/// `Words` has no_error_flag or unchecked if the format has no nE or no CRC: BissReader<format,
/// biss::SpiSetup{.no_error_flag = true}>
template <biss::FrameFormat Format, biss::SpiSetup Words = biss::SpiSetup{}>
class BissReader {
  static constexpr biss::SpiSetup setup_of(std::uint32_t clock, biss::Picoseconds line_delay_max) {
    biss::SpiSetup setup = Words;
    setup.period = biss::period_of(biss::hertz(clock));
    setup.line_delay = {.max = line_delay_max};
    return setup;
  }
  static constexpr auto refused = biss::check_spi(Format, setup_of(1'000'000, {}), {});
  static_assert(refused != biss::SpiSetupError::error_flag, "no nE: see no_error_flag");
  static_assert(refused != biss::SpiSetupError::crc, "no CRC: see unchecked");
  static_assert(refused != biss::SpiSetupError::previous, "one frame cannot be checked");

 public:
  /// \param clock of MA, in hertz. The core may round it down, so choose one that it can make
  /// \param line_delay_max of cable and encoder, there and back
  explicit BissReader(SPIClass& spi, std::uint32_t clock, const biss::DeviceTiming& timing = {},
                      biss::Picoseconds line_delay_max = biss::nanoseconds(1000))
      : spi_(spi),
        clock_(clock),
        reader_(biss::FixedCodec<Format>{}, setup_of(clock, line_delay_max), timing) {}

  /// Call it in setup().
  void begin() {
    spi_.begin();
    // Makes the idle level of SCK high.
    spi_.beginTransaction(settings());
    spi_.endTransaction();
  }

  /// Why nothing can be read, for example `clock`: it is above the limit of `timing`.
  const std::optional<biss::SpiSetupError>& error() const { return reader_.error(); }

  /// Bytes of one transfer; 0 if there is an error(), or if they do not fit: then choose a lower
  /// clock.
  std::size_t bytes() const { return reader_.bytes() <= buffer_.size() ? reader_.bytes() : 0; }

  /// Requests a position. Wait for the timeout of the encoder between two calls.
  BissReading read() {
    if (bytes() == 0) return {.fault = biss::FrameFault{biss::FrameError::truncated}};
    buffer_.fill(0xFF);  // bytes that are not received give no_response
    spi_.beginTransaction(settings());
    spi_.transfer(buffer_.data(), bytes());
    spi_.endTransaction();
    const auto frame = reader_.read(std::span<const std::uint8_t>(buffer_).first(bytes()));
    if (!frame.ok()) return {.fault = frame.error()};
    const biss::Channel& channel = frame->channels()[0];
    return {.position = channel.position, .nE = frame->trusted(), .nW = channel.nW};
  }

 private:
  SPISettings settings() const { return SPISettings(clock_, MSBFIRST, SPI_MODE3); }

  SPIClass& spi_;
  std::uint32_t clock_;
  biss::SpiReader<biss::FixedCodec<Format>> reader_;
  // 40 us of ACK, 40 us of line delay and 128 bits of data at 10 MHz need 117 bytes.
  std::array<std::uint8_t, 128> buffer_{};
};
