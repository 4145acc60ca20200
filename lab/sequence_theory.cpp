#include "lab/sequence_theory.hpp"

#include <array>
#include <cmath>

#include "lab/campaign_theory.hpp"
#include "lab/equations.hpp"

namespace biss::lab {
namespace {

long double power_of_half(unsigned n) { return std::ldexp(1.0L, -static_cast<int>(n)); }

// Safety words that the monitor accepts with one control word: positions within the tolerance, any
// value of the bits that are not checked, one counter, nE = 1. The CRC follows.
long double good_words(const SequenceFrame& frame) {
  const unsigned compared = frame.plan().alignment().bits;
  const unsigned judged = compared + safety_counter_bits + 1U;
  const unsigned positions = 2U * frame.setup().comparison.tolerance_lsb + 1U;
  return positions / power_of_half(frame.words().spw_format().data_bits - judged);
}

// For each counter, the positions for which both polynomials give the same CRC are the solutions of
// linear equations.
long double same_crc_theory(const SequenceFrame& frame, const SequenceFrame::Codec& other,
                            unsigned first_counter) {
  const ChannelFormat& cpw = frame.words().cpw_format();
  const ChannelFormat& spw = frame.words().spw_format();
  const auto apart = [&](std::uint64_t position, std::uint32_t counter) -> std::uint32_t {
    const Channel values{.position = spw_position(cpw, spw, position), .life_counter = counter};
    const std::uint64_t data = pack(spw, values);
    return frame.codec().crc(1, data, false) ^ other.crc(1, data, false);
  };
  using PositionEquations = Equations<64>;
  const std::uint32_t zero = apart(0, 0);
  std::array<PositionEquations::Bit, max_crc_bits> sums{};
  for (unsigned bit = 0; bit < cpw.position_bits(); ++bit) {
    const std::uint32_t column = apart(std::uint64_t{1} << bit, 0) ^ zero;
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k][bit] = ((column >> k) & 1U) != 0;
  }
  long double share = 0;
  for (unsigned counter = first_counter; counter < 64; ++counter) {
    const std::uint32_t constant = apart(0, counter);
    PositionEquations equations;
    for (std::size_t k = 0; k < sums.size(); ++k) {
      equations.require(sums[k], ((constant >> k) & 1U) != 0);
    }
    share += equations.share();
  }
  return share / (64 - first_counter);
}

}  // namespace

// The word that was sent is not a fault.
std::optional<long double> noise_word_theory(const SequenceFrame& frame, const SequenceRow&) {
  return (good_words(frame) - 1) * power_of_half(frame.words().spw_bits());
}

// Every control word with nE = 1 is a good one.
std::optional<long double> noise_theory(const SequenceFrame& frame, const SequenceRow&) {
  const long double cpw_words = 1 / power_of_half(frame.words().cpw_format().data_bits - 1U);
  return (cpw_words * good_words(frame) - 1) * power_of_half(frame.words().bits());
}

// Flips are drawn again until there is at least one.
std::optional<long double> corruption_theory(const SequenceFrame& frame, const SequenceRow& row) {
  const FaultChoice choice = *parse_fault(row.variant_name());
  const bool flips = choice.kind == FaultKind::flips;
  const long double rate = probability_of(choice.rate);
  const long double none = flips ? std::pow(1 - rate, frame.words().bits()) : 0;
  if (flips && rate == 0.5L) return *noise_theory(frame, row) / (1 - none);
  const auto theory = campaign_theory(frame.words(), choice);
  if (!theory) return std::nullopt;
  return (*theory)[static_cast<std::size_t>(Acceptance::monitor)] / (1 - none);
}

std::optional<long double> polynomial_theory(const SequenceFrame& frame, const SequenceRow&) {
  long double sum = 0;
  for (const SequenceFrame::Codec& other : frame.other_polynomials()) {
    sum += same_crc_theory(frame, other, frame.words().first_counter());
  }
  return sum / static_cast<long double>(frame.other_polynomials().size());
}

std::optional<long double> standard_theory(const SequenceFrame& frame, const SequenceRow&) {
  const ChannelFormat& spw = frame.words().spw_format();
  const bool refused = frame.codec().crc(1, 0, false) != 0 || !unpack(spw, 0).nE;
  return refused ? std::optional(0.0L) : std::nullopt;
}

std::optional<long double> counter_theory(const SequenceFrame&, const SequenceRow& row) {
  return 1.0L / row.period();
}

std::optional<long double> insertion_theory(const SequenceFrame& frame, const SequenceRow& row) {
  const Picoseconds gap = frame.cycle() - frame.cycle() / 2;
  return gap < frame.setup().frame_gap_min ? 0 : counter_theory(frame, row);
}

std::optional<long double> sequence_theory(const SequenceFrame& frame, const SequenceRow& row) {
  const bool known = row.task == SequenceTask::fault && row.injection().theory != nullptr;
  return known ? row.injection().theory(frame, row) : 0;
}

}  // namespace biss::lab
