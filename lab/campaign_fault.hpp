// What a campaign does to frames, as text and as data.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace biss::lab {

/// Faults of the bits from the first of the control word to the last of the safety word, and of
/// what frames them. Names are those of the line model or of lab/structure.hpp where they have the
/// same.
enum class CampaignFault : std::uint8_t {
  flips,          ///< each bit is wrong with the same probability, independently of the others
  burst,          ///< so many bits in a row, the first and the last one wrong, the others at random
  lost_clock,     ///< the encoder misses a clock: from one bit on, each is read as the next one
  double_clock,   ///< the encoder sees a clock twice: from one bit on, each is read as the one
                  ///< before
  slo_low,        ///< the line is low from one bit on, STOP included
  slo_high,       ///< the line is high from one bit on, STOP included
  inserted_low,   ///< a 0 is seen before one bit: each from there on is read a clock late
  inserted_high,  ///< the same with a 1
  gap_low,        ///< so many bits in a row read 0, then the frame goes on
  gap_high,       ///< the same with 1
  late_start,     ///< START reads 0, the next 1 is taken for it; behind STOP the line is low
  early_start,    ///< a bit of ACK reads 1 and is taken for START
  cds_high,       ///< CDS reads 1
  stop_high,      ///< STOP reads 1
};

/// A fault as the user gives it. Probabilities are parts of 2^32, so that theory speaks of exactly
/// what is drawn.
struct FaultChoice {
  CampaignFault kind{};
  /// flips: of a bit to be wrong; 1 to 2^31.
  std::uint32_t rate = 0;
  /// flips: drawn with this probability instead, and weighed by how much likelier a pattern became;
  /// 0: no importance sampling.
  std::uint32_t drawn_rate = 0;
  /// flips: drawn so that they fit the checks, and weighed; see FittingDraws. Not with drawn_rate.
  bool fitting = false;
  /// burst: bits, 2 to 32. gap_low, gap_high: 1 to 32.
  unsigned length_bits = 0;
  /// The first bit that it strikes, from 0; else drawn. early_start: in ACK, 0 for its last clock.
  /// Not for flips, late_start, cds_high and stop_high.
  std::optional<unsigned> place{};

  bool operator==(const FaultChoice&) const = default;
  /// Drawn otherwise than the fault says, and weighed.
  bool weighed() const { return drawn_rate != 0 || fitting; }
  /// What is drawn in fact.
  std::uint32_t sampling_rate() const { return drawn_rate != 0 ? drawn_rate : rate; }
};

inline constexpr unsigned max_burst_bits = 32;

constexpr bool has_length(CampaignFault kind) {
  return kind == CampaignFault::burst || kind == CampaignFault::gap_low ||
         kind == CampaignFault::gap_high;
}
constexpr bool is_high(CampaignFault kind) {
  return kind == CampaignFault::slo_high || kind == CampaignFault::inserted_high ||
         kind == CampaignFault::gap_high;
}
/// Whether the bits around the two words are struck, and not theirs.
constexpr bool is_around(CampaignFault kind) { return kind >= CampaignFault::late_start; }

/// `flips:RATE[:DRAWN]`, `flips:RATE:fitting`, `burst:BITS[:PLACE]`, or the name of another kind
/// with `[:PLACE]`. Rates are from 2^-32 to 0.5. \return none where it is nothing of the kind
std::optional<FaultChoice> parse_fault(std::string_view text);

/// The text that parses to the same.
std::string text_of(const FaultChoice& fault);

/// A part of 2^32 as a number.
constexpr long double probability_of(std::uint32_t rate) {
  return static_cast<long double>(rate) / 4294967296.0L;
}

}  // namespace biss::lab
