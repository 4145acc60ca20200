// Which protocol the lines of a capture carry: BiSS C, one of its neighbours, or none.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "wire/edge.hpp"

namespace biss::identify {

enum class Protocol : std::uint8_t {
  biss_c,
  ssi,
  endat22,
  hiperface_dsl,
  serial_encoder,  ///< asynchronous words of an encoder: Tamagawa, Panasonic, Nikon
  spi,
  i2c,
  uart,
  quadrature,   ///< A and B of an incremental encoder
  clock_alone,  ///< a clock that no line answers
  noise,
  idle,  ///< no line changes
  unknown,
};

inline constexpr std::size_t protocol_count = 13;

constexpr std::string_view name_of(Protocol protocol) {
  constexpr std::array<std::string_view, protocol_count> names{
      "biss_c", "ssi",        "endat22",     "hiperface_dsl", "serial_encoder", "spi",    "i2c",
      "uart",   "quadrature", "clock_alone", "noise",         "idle",           "unknown"};
  return names[static_cast<std::size_t>(protocol)];
}

/// A protocol that the lines may carry.
struct ProtocolGuess {
  Protocol protocol = Protocol::unknown;
  /// 0 to 1.
  double confidence = 0;
  /// The figures of this capture that support it, one line.
  std::string why;
};

/// Judges which protocol the lines carry from their levels alone, best first; never empty. A
/// protocol other than BiSS C is first only if it is clear; else `unknown` is first.
///
/// Examines the first changes of the busiest lines, in both roles and both polarities. Time and
/// memory are bounded.
/// \param beginning edges from the beginning of the capture, in time order
/// \param lines the number of lines of the capture
/// \param sample_period the time between two samples of the capture; 0 if it holds changes
/// \param end the end of `beginning`, not before its last edge
std::vector<ProtocolGuess> recognise_protocol(std::span<const wire::Edge> beginning,
                                              std::size_t lines, Picoseconds sample_period,
                                              Picoseconds end);

}  // namespace biss::identify
