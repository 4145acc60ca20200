// An SPI controller as its wires show it: the clock, MOSI and MISO, edge by edge.
#pragma once

#include <cstdint>

#include "biss/base/units.hpp"
#include "live/virtual_encoder.hpp"

namespace biss::live {

/// The output of the controller that is MA.
enum class MaSource : std::uint8_t { sck, mosi };

struct ControllerSetup {
  /// Its clock, which it divides by an even number; 0: it reaches every rate.
  Hertz clock{};
  /// SCK rests this long after each word.
  Picoseconds word_gap{};
  MaSource ma = MaSource::sck;
};

/// The modes of SPI.
struct SpiMode {
  bool clock_idle = false;   ///< CPOL
  bool second_edge = false;  ///< CPHA: sample at the second edge of each clock
  bool lsb_first = false;
};

/// The encoder on the wires of one controller. SCK takes the idle level of a mode when a message in
/// this mode begins, and MOSI keeps its last level; MA is high before that.
class SpiBus {
 public:
  /// \param encoder outlives it
  SpiBus(VirtualEncoder& encoder, const ControllerSetup& setup)
      : encoder_(encoder), setup_(setup) {}

  Hertz rate_min() const;
  Hertz rate_max() const;
  /// The period at the highest rate that is not above this one.
  /// \pre rate is within the limits above
  Picoseconds period_at(Hertz rate) const;

  /// A message begins now, or when the previous one has ended.
  void begin(Picoseconds now, SpiMode mode, Picoseconds period);
  /// Shifts one word. \param bits 1 to 32, in the low bits of `out` and of the result
  std::uint32_t exchange(std::uint32_t out, unsigned bits, Picoseconds period,
                         Picoseconds more_gap);
  void pause(Picoseconds duration) { time_ += duration; }
  /// The end of what was done so far.
  Picoseconds time() const { return time_; }

 private:
  bool exchange_bit(bool out, Picoseconds period);

  VirtualEncoder& encoder_;
  ControllerSetup setup_;
  SpiMode mode_;
  Picoseconds time_{};
  bool sck_ = true;
};

}  // namespace biss::live
