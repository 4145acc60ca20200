// The faults that a campaign injects into frames, as text and as data.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "sim/fault.hpp"

namespace biss::lab {

using sim::FaultKind;

/// The kinds that a campaign injects: errors in the bits from the first of the control word to the
/// last of the safety word, and in the bits around them.
inline constexpr std::array<FaultKind, 14> campaign_faults{
    FaultKind::flips,    FaultKind::burst,    FaultKind::lost_bit,     FaultKind::doubled_bit,
    FaultKind::slo_low,  FaultKind::slo_high, FaultKind::inserted_low, FaultKind::inserted_high,
    FaultKind::gap_low,  FaultKind::gap_high, FaultKind::lost_start,   FaultKind::false_start,
    FaultKind::cds_high, FaultKind::stop_high};

/// One fault of a campaign. Probabilities are parts of 2^32, so that theory and random numbers use
/// exactly the same ones.
struct FaultChoice {
  FaultKind kind = FaultKind::flips;
  /// flips: the probability of a wrong bit; 1 to 2^31.
  std::uint32_t rate = 0;
  /// flips, importance sampling: bits are drawn with this probability, and patterns are weighted by
  /// their likelihood ratio. 0: no importance sampling.
  std::uint32_t drawn_rate = 0;
  /// flips, importance sampling: patterns are drawn so that they pass the checks, and weighted; see
  /// FittingDraws. Not with drawn_rate.
  bool fitting = false;
  /// burst: bits, 2 to 32. gap_low, gap_high: 1 to 32.
  unsigned length_bits = 0;
  /// The first bit affected, from 0; else drawn. false_start: the clock of ACK, 0 for the last one.
  /// Not for flips, lost_start, cds_high and stop_high.
  std::optional<unsigned> place{};

  bool operator==(const FaultChoice&) const = default;
  /// Whether importance sampling is used.
  bool weighted() const { return drawn_rate != 0 || fitting; }
  /// The probability with which bits are drawn.
  std::uint32_t sampling_rate() const { return drawn_rate != 0 ? drawn_rate : rate; }
};

inline constexpr unsigned max_burst_bits = 32;

constexpr bool has_length(FaultKind kind) {
  return kind == FaultKind::burst || kind == FaultKind::gap_low || kind == FaultKind::gap_high;
}
constexpr bool is_high(FaultKind kind) {
  return kind == FaultKind::slo_high || kind == FaultKind::inserted_high ||
         kind == FaultKind::gap_high;
}
/// Whether the fault affects bits around the two words, and not the words themselves.
constexpr bool is_around(FaultKind kind) {
  return kind == FaultKind::lost_start || kind == FaultKind::false_start ||
         kind == FaultKind::cds_high || kind == FaultKind::stop_high;
}

/// Parses `flips:RATE[:DRAWN]`, `flips:RATE:fitting`, `burst:BITS[:PLACE]`, `gap_low:BITS[:PLACE]`,
/// `gap_high:BITS[:PLACE]`, or the name of another kind with `[:PLACE]`. Rates are from 2^-32 to
/// 0.5. \return nothing if the text is none of these
std::optional<FaultChoice> parse_fault(std::string_view text);

/// Returns the text that parses to the same fault.
std::string text_of(const FaultChoice& fault);

/// A rate in units of 2^-32 as a probability.
constexpr long double probability_of(std::uint32_t rate) {
  return static_cast<long double>(rate) / 4294967296.0L;
}

/// Bits that are 1 with a probability of rate / 2^32 each: a uniform number is compared with the
/// rate from the highest bit on until it is decided for every bit.
/// \param next draws uniform bits
/// \param any returns whether any bit is 1
template <class Bits, class Next, class Any>
Bits chosen_bits(std::uint32_t rate, const Next& next, const Any& any) {
  Bits open = ~Bits{};
  Bits below{};
  for (; rate != 0 && any(open); rate <<= 1U) {
    const Bits drawn = next();
    if ((rate >> 31U) != 0) {
      below |= open & ~drawn;
      open &= drawn;
    } else {
      open &= ~drawn;
    }
  }
  return below;
}

/// Both words and STOP; bit 0 is STOP.
__extension__ using LineWord = unsigned __int128;

/// The number of places at which a fault can begin in a payload; 0 if the fault is longer than the
/// payload.
constexpr unsigned places_of(const FaultChoice& fault, unsigned payload_bits) {
  switch (fault.kind) {
    case FaultKind::burst:
      return fault.length_bits > payload_bits ? 0 : payload_bits - fault.length_bits + 1U;
    case FaultKind::false_start:  // at more distant places only zeros are read
      return payload_bits + 1U;
    case FaultKind::lost_start:
    case FaultKind::cds_high:
    case FaultKind::stop_high:
      return 1;
    default:
      return payload_bits;
  }
}

/// The line with the fault; unchanged if the fault affects none of these bits.
/// \param size_bits payload and STOP
/// \param place bits from the beginning of the payload
/// \param pattern burst: the lower bits are those between the first and the last wrong bit
constexpr LineWord damaged(LineWord line, unsigned size_bits, const FaultChoice& fault,
                           unsigned place, std::uint64_t pattern) {
  const unsigned after = size_bits - place;  // bits from the place on
  const LineWord tail = (LineWord{1} << after) - 1U;
  const LineWord level = is_high(fault.kind) ? ~LineWord{0} : 0;
  switch (fault.kind) {
    case FaultKind::stop_high:
      return line | 1U;
    case FaultKind::burst: {
      const unsigned inside = fault.length_bits - 2U;
      const LineWord between = pattern & ((std::uint64_t{1} << inside) - 1U);
      const LineWord wrong = (LineWord{1} << (fault.length_bits - 1U)) | (between << 1U) | 1U;
      return line ^ (wrong << (after - fault.length_bits));
    }
    case FaultKind::lost_bit:  // after STOP the line is low
      return (line & ~tail) | ((line << 1U) & tail);
    case FaultKind::doubled_bit:
    case FaultKind::inserted_low:
    case FaultKind::inserted_high: {
      const LineWord rest = tail >> 1U;
      const LineWord first = fault.kind == FaultKind::doubled_bit ? line : level;
      return (line & ~tail) | (first & tail & ~rest) | ((line >> 1U) & rest);
    }
    case FaultKind::gap_low:
    case FaultKind::gap_high: {
      const LineWord rest = fault.length_bits >= after ? 0 : tail >> fault.length_bits;
      return (line & ~(tail & ~rest)) | (level & tail & ~rest);
    }
    case FaultKind::slo_low:
    case FaultKind::slo_high:
      return (line & ~tail) | (level & tail);
    default:
      return line;
  }
}

}  // namespace biss::lab
