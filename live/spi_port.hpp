// A real line at an SPI port of Linux (spidev): its clock is MA, its data input is SLO.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/units.hpp"

namespace biss::live {

/// The pin of the port that is MA.
enum class MaPin : std::uint8_t {
  sck,   ///< the clock, mode 3: one bit for each clock of MA
  mosi,  ///< the data output, two bits for each clock of MA; the clock pin is not connected
};

struct SpiPortSetup {
  std::string path;
  Hertz clock{};  ///< of MA
  MaPin ma = MaPin::sck;
};

/// Why a transfer gave no bytes.
enum class PortFault : std::uint8_t {
  gone,            ///< the device has vanished
  busy,            ///< another program uses the controller
  too_long,        ///< more bytes than the driver takes: its module parameter `bufsiz`
  timed_out,       ///< the controller did not end the transfer
  short_transfer,  ///< it transferred fewer bytes
  failed,          ///< any other error of the driver
};
inline constexpr std::size_t port_fault_count = 6;

constexpr std::string_view name_of(PortFault fault) {
  constexpr std::string_view names[] = {"gone",      "busy",           "too_long",
                                        "timed_out", "short_transfer", "failed"};
  return names[static_cast<std::size_t>(fault)];
}

/// The clock that a controller reaches, measured.
struct ReachedClock {
  Hertz clock{};
  /// The clock is within `clock` ± this.
  Hertz uncertainty{};
};

class SpiPort {
 public:
  /// \return the port, or one line: what is wrong and what to do
  static tl::expected<SpiPort, std::string> open(const SpiPortSetup& setup);
  SpiPort(SpiPort&& other) noexcept;
  SpiPort& operator=(SpiPort&&) = delete;
  ~SpiPort();

  /// The next transfers hold MA at the level of this CDM until the longest timeout is over, and
  /// return it to high. \pre MaPin::mosi
  void end_with(bool cdm) { cdm_ = cdm; }
  /// Clocks MA, and receives a bit for each clock, the first one in the highest bit.
  std::optional<PortFault> transfer(std::span<std::uint8_t> receive);
  /// The errno of the last fault; 0 if it has none.
  int error() const { return error_; }

  /// Opens the device again after it was `gone`.
  bool reopen();

  /// Measures transfers of two lengths, for 300 ms at most. Nothing if a transfer fails, go_on() is
  /// false, or the times differ by so much that they show no clock.
  std::optional<ReachedClock> measure_clock(const std::function<bool()>& go_on);

 private:
  explicit SpiPort(SpiPortSetup setup) : setup_(std::move(setup)) {}
  std::string start();

  SpiPortSetup setup_;
  int descriptor_ = -1;
  int error_ = 0;
  std::optional<bool> cdm_;
  // With MaPin::mosi: what is sent, and what came back.
  std::vector<std::uint8_t> sent_;
  std::vector<std::uint8_t> sampled_;
};

}  // namespace biss::live
