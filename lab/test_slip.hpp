// The share of data words that a reader accepts when it sees START at a wrong place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/frame/format.hpp"
#include "lab/frame_line.hpp"

namespace biss::lab {

/// The frame from the encoder, and the checks of the reader, when START is seen at a wrong place.
/// Position and counter bits are independent and evenly distributed; padding is 0.
struct SlipModel {
  /// The flags show "no error, no warning". false: they are evenly distributed too.
  bool healthy_flags = true;
  /// The CDS bit that the encoder sends.
  bool cds = false;
  /// The position of every further channel is the upper bits of the first channel's position, as in
  /// a safety word. false: independent.
  bool aligned_words = false;
  /// Count only frames that pass Frame::trusted().
  bool trusted_only = false;
  /// SLO must be low after STOP up to the last clock (SpiTail::must_stay_low).
  bool tail_checked = false;
};

/// A START at the wrong place. Places count clocks from the true START, negative before it.
struct Slip {
  /// The place at which START is seen; not 0.
  int place = 1;
  /// Zeros that the encoder sent as ACK; before them the line was 1.
  std::uint16_t ack_clocks = 1;
  /// Only with place > 0: this many bits after the true START are 1 and extend the leading ones, as
  /// when a single ACK bit was lost. The bits from there to `place` are the ACK that is seen.
  std::uint16_t ones_clocks = 0;
};

/// START is read as 0, and the 1 that follows `distance_clocks` (1…) later is taken for START.
constexpr Slip lost_start(unsigned distance_clocks) {
  return {.place = static_cast<int>(distance_clocks)};
}
/// The ACK bit `early_clocks` (1…) before START is read as 1 and taken for START.
constexpr Slip false_start(unsigned early_clocks) {
  return {.place = -static_cast<int>(early_clocks),
          .ack_clocks = static_cast<std::uint16_t>(early_clocks)};
}

/// Returns the number of independent conditions c: the share 2^-c of data words is accepted. Enough
/// clocks are assumed to reach the STOP of the slipped frame. A word that passes is counted even if
/// the slipped position happens to be right (all bits 1, for example).
/// \pre ones_clocks is 0 or less than place - 1
/// \return nothing if no word passes. With place > 0: the share of all data words, also those whose
///   next 1 is elsewhere
inline std::optional<unsigned> slip_conditions(const FrameFormat& format, const Slip& slip,
                                               const SlipModel& model = {}) {
  const FrameLine line(format, {.cds = model.cds,
                                .healthy_flags = model.healthy_flags,
                                .aligned_channels = model.aligned_words ? max_channels : 1U});
  const auto sent = [&](int at) {
    return at < -int{slip.ack_clocks} ? level_bit(true) : line.sent(at);
  };
  const int stop = static_cast<int>(line.frame_bits()) - 1;
  // The frame as it is read if the 1 at `place` is taken for START.
  LinearBits seen;
  for (int at = slip.place; at <= slip.place + stop; ++at) seen.push_back(sent(at));
  LineEquations equations;
  for (int at = 1; at <= slip.place; ++at) {
    equations.require(sent(at), at <= int{slip.ones_clocks} || at == slip.place);
  }
  line.require_structure(equations, seen);
  for (int at = slip.place + stop + 1; model.tail_checked && at < stop; ++at) {
    equations.require(sent(at), false);
  }
  if (model.trusted_only) line.require_no_error(equations, seen);
  for (std::size_t k = 0; k < format.channel_count; ++k) {
    line.require_checksum(equations, seen, k);
  }
  return equations.possible() ? std::optional(equations.rank()) : std::nullopt;
}

}  // namespace biss::lab
