// The possible kinds of a request, and the cost of each in bits: the lower, the better it predicts
// the edges that were seen.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/frame/codec.hpp"
#include "decode/cycle_edges.hpp"
#include "explain/checksum_variant.hpp"

namespace biss::explain {

enum class RequestKind : std::uint8_t {
  ok,
  error_flag,      ///< a good frame with nE = 0
  life_jump,       ///< a good frame whose sign of life is not one more than before
  implausible,     ///< a good frame whose position no axis can have
  short_frame,     ///< a frame for control communication alone
  other_length,    ///< a frame with more or fewer bits than usual
  paused,          ///< a good frame, MA rests inside it
  flip,            ///< bits are wrong
  refused,         ///< nothing is unusual, except that the format does not fit
  slip,            ///< the encoder has counted a clock too many or too few
  silent,          ///< SLO stayed high
  stuck,           ///< SLO was low until the next request
  busy,            ///< SLO was low at the request and rose later
  hurried,         ///< SLO was low at a request that came sooner than before good frames
  inverted,        ///< SLO rests low and rises for ACK
  half_early,      ///< SLO changes with the falling edges of MA
  stop_repeats,    ///< STOP has the level of the bit before
  cut_in_ack,      ///< MA stopped before START
  cut_late,        ///< START came later than in any good frame, and bits are missing
  cut_in_data,     ///< START came in time, and MA stopped before the last bit
  restart,         ///< as before, and the next clocks come soon
  ma_held,         ///< MA stopped within the request: it stays low, or one next to it is missing
  ones,            ///< SLO stayed high from a bit on to the end, STOP included
  zeros,           ///< SLO stayed low from a bit on to the end
  slo_pulse,       ///< a pulse on SLO, the frame otherwise good
  ma_pulse,        ///< a pulse on MA, the frame otherwise good
  smeared,         ///< a good frame, SLO changes far from its usual place in a bit
  delay_part,      ///< a good frame, the line delay differs by a part of a period
  delay_clocks,    ///< a good frame, one or more clocks later than usual
  stop_high,       ///< STOP is 1, the frame otherwise good
  cds_high,        ///< CDS is 1, 0 by the format; the frame otherwise good
  other_ack,       ///< START outside the bounds of the encoder, the frame otherwise good
  other_checksum,  ///< the checksum is right by a maker's rule
  foreign,         ///< each clock is a bit of a number that moves
  literal,         ///< as it was seen, without a reason
};

inline constexpr std::size_t kind_count = 35;

/// A few words for the evidence: "N of M cycles: …".
std::string_view text_of(RequestKind kind);

/// In bits, for one request; `impossible` for a kind that it is not.
using Prices = std::array<float, kind_count>;
inline constexpr float impossible = 1e9F;

/// The usual shape of the requests of a capture, from its beginning.
struct Usual {
  Picoseconds period{};
  /// How long MA is high in a period.
  Picoseconds high{};
  Picoseconds delay{};
  /// The number of bits between CDS and STOP: from the format, else from the frames.
  unsigned payload_bits = 0;
  /// Rising edges of MA.
  std::uint32_t clocks = 0;
  std::optional<ChecksumVariant> checksum;
  /// Almost no frame has the right checksum, and no rule fits.
  bool no_checksum_fits = false;
  /// If requests come in groups, each of which begins like a request of BiSS C: the usual pause in
  /// a group.
  std::optional<Picoseconds> rest_in_group;
};
/// \param cycles from the beginning of the capture
Usual usual_of(std::span<const decode::Cycle> cycles, const std::optional<FrameFormat>& format);

}  // namespace biss::explain
