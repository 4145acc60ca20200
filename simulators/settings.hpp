// The settings of an instance, as text: `format=resolute-26 line_delay=0,333ns faults=none,flip`.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "capi/biss_c.h"

namespace biss::simulators {

/// How the position of a request is chosen.
enum class PositionKind : std::uint8_t {
  number,
  largest,  ///< all bits 1
  walk,     ///< one bit 1, the next one with each request
  ramp,     ///< the number of the request
  random,
};

struct PositionChoice {
  PositionKind kind = PositionKind::random;
  std::uint64_t number = 0;
};

/// nE and nW of a request, as in biss_channel.
struct Flags {
  bool nE = true;
  bool nW = true;
};

/// The faults of an encoder. Names and meanings as in sim/fault.hpp, if it has the fault.
enum class Fault : std::uint8_t {
  none,
  flip,          ///< one bit of data or CRC is inverted: crc
  flip_crc,      ///< one bit of the CRC is inverted, each time the next one: crc
  burst,         ///< consecutive bits of one channel, at most as many as its CRC has: crc
  crc_polarity,  ///< all bits of each CRC are inverted: crc
  no_answer,     ///< the encoder ignores the request: no_response
  early_ack,     ///< SLO falls with LAT: response_range
  slo_low,       ///< SLO stays at 0 after ACK: no_start
  cds_high,      ///< CDS is 1: cds, with `cds0` in the format
  stop_high,     ///< STOP is 1: stop_bit
};

/// Whether each channel has a CRC.
bool has_crcs(const FrameFormat& format);

/// The cause that a master must report for this fault. \param cds0 the option of the format
biss_cause cause_of(Fault fault, bool cds0);

/// The values of lists are used in turn, one with each request.
struct Settings {
  std::string format_text;
  FrameFormat format;
  /// The same, with the timing of the device and the timeout of the settings.
  biss_format device{};
  std::vector<Picoseconds> line_delays{Picoseconds{}};
  /// Each edge of SLO comes 0 to this later.
  Picoseconds jitter{};
  std::uint64_t seed = 1;
  // For encoders.
  std::vector<Picoseconds> processing{Picoseconds{}};
  std::vector<PositionChoice> positions{{PositionKind::random, 0}};
  std::vector<Flags> flags{{}};
  std::vector<Fault> faults{Fault::none};
  std::map<std::uint8_t, std::uint8_t> registers;
  // For masters.
  std::vector<Hertz> clocks{megahertz(1)};
  std::vector<Picoseconds> pauses{Picoseconds{}};
  std::vector<bool> cdm{false};
};

enum class Role : std::uint8_t { encoder, master };

/// The error is one line.
tl::expected<Settings, std::string> read_settings(Role role, std::string_view text);

/// The value for this request.
template <class Value>
Value in_turn(const std::vector<Value>& values, std::uint64_t request) {
  return values[request % values.size()];
}

}  // namespace biss::simulators
