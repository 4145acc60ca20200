#include "lab/sequence_theory.hpp"

#include <array>
#include <cmath>

#include "lab/campaign_theory.hpp"

namespace biss::lab {
namespace {

long double power_of_half(unsigned n) { return std::ldexp(1.0L, -static_cast<int>(n)); }

// Safety words that the monitor takes beside one control word: the positions within the tolerance,
// with all bits that nobody looks at, one counter, nE = 1. The CRC follows.
long double good_words(const SequenceFrame& frame) {
  const unsigned compared = frame.ready().plan().alignment().bits;
  const unsigned judged = compared + safety_counter_bits + 1U;
  const unsigned positions = 2U * frame.setup().comparison.tolerance_lsb + 1U;
  return positions / power_of_half(frame.words().spw_format().data_bits - judged);
}

// Random bits in the place of the safety word; the word that was sent is no fault.
long double noise_word_theory(const SequenceFrame& frame) {
  return (good_words(frame) - 1) * power_of_half(frame.words().spw_bits());
}

// The same of both words: every control word with nE = 1.
long double noise_theory(const SequenceFrame& frame) {
  const long double cpw_words = 1 / power_of_half(frame.words().cpw_format().data_bits - 1U);
  return (cpw_words * good_words(frame) - 1) * power_of_half(frame.words().bits());
}

// Flips are drawn again until there is one.
std::optional<long double> corruption_theory(const SequenceFrame& frame, std::string_view fault) {
  const FaultChoice choice = *parse_fault(fault);
  const bool flips = choice.kind == CampaignFault::flips;
  const long double rate = probability_of(choice.rate);
  const long double none = flips ? std::pow(1 - rate, frame.words().bits()) : 0;
  if (flips && rate == 0.5L) return noise_theory(frame) / (1 - none);
  const auto theory = campaign_theory(frame.words(), choice);
  if (!theory) return std::nullopt;
  return (*theory)[static_cast<std::size_t>(Acceptance::monitor)] / (1 - none);
}

// A space of words over GF(2).
class Span {
 public:
  void add(std::uint32_t word) {
    word = rest(word);
    if (word == 0) return;
    basis_[static_cast<std::size_t>(std::bit_width(word))] = word;
    ++rank_;
  }
  bool holds(std::uint32_t word) const { return rest(word) == 0; }
  unsigned rank() const { return rank_; }

 private:
  std::uint32_t rest(std::uint32_t word) const {
    for (std::size_t top = basis_.size() - 1; top != 0; --top) {
      if (((word >> (top - 1U)) & 1U) != 0) word ^= basis_[top];
    }
    return word;
  }

  std::array<std::uint32_t, 17> basis_{};
  unsigned rank_ = 0;
};

// The positions for which both polynomials give the same CRC are the solutions of linear equations;
// one set for each counter.
long double same_crc_theory(const SequenceFrame& frame, const SequenceFrame::Codec& other,
                            unsigned first_counter) {
  const ChannelFormat& cpw = frame.words().cpw_format();
  const ChannelFormat& spw = frame.words().spw_format();
  const auto apart = [&](std::uint64_t position, std::uint32_t counter) -> std::uint32_t {
    const Channel values{.position = spw_position(cpw, spw, position), .life_counter = counter};
    const std::uint64_t data = pack(spw, values);
    return frame.codec().crc(1, data) ^ other.crc(1, data);
  };
  Span positions;
  const std::uint32_t zero = apart(0, 0);
  for (unsigned bit = 0; bit < cpw.position_bits(); ++bit) {
    positions.add(apart(std::uint64_t{1} << bit, 0) ^ zero);
  }
  unsigned solvable = 0;
  for (unsigned counter = first_counter; counter < 64; ++counter) {
    if (positions.holds(apart(0, counter))) ++solvable;
  }
  return power_of_half(positions.rank()) * solvable / (64 - first_counter);
}

long double polynomial_theory(const SequenceFrame& frame) {
  long double sum = 0;
  for (const SequenceFrame::Codec& other : frame.other_polynomials()) {
    sum += same_crc_theory(frame, other, frame.words().first_counter());
  }
  return sum / static_cast<long double>(frame.other_polynomials().size());
}

// Zeros in the place of the safety word.
std::optional<long double> standard_theory(const SequenceFrame& frame) {
  const ChannelFormat& spw = frame.words().spw_format();
  const bool refused = frame.codec().crc(1, 0) != 0 || !unpack(spw, 0).nE;
  return refused ? std::optional(0.0L) : std::nullopt;
}

constexpr double far_away = 38;

// The normal deviate that is exceeded with this probability.
double deviate(long double probability) {
  double low = 0;
  double high = far_away;
  for (int step = 0; step < 60; ++step) {
    const double middle = (low + high) / 2;
    const long double above = std::erfc(static_cast<long double>(middle) / std::sqrt(2.0L)) / 2;
    (above > probability ? low : high) = middle;
  }
  return low;
}

// P(at least so many) under Poisson's distribution.
long double at_least(std::uint64_t count, long double mean) {
  long double term = std::exp(static_cast<long double>(count) * std::log(mean) - mean -
                              std::lgamma(static_cast<long double>(count) + 1));
  long double sum = 0;
  for (std::uint64_t n = count; term > sum * 1e-20L; ++n) {
    sum += term;
    term *= mean / static_cast<long double>(n + 1);
  }
  return std::min(1.0L, sum);
}

long double at_most(std::uint64_t count, long double mean) {
  long double term = std::exp(-mean);
  long double sum = term;
  for (std::uint64_t n = 1; n <= count; ++n) {
    term *= mean / static_cast<long double>(n);
    sum += term;
  }
  return std::min(1.0L, sum);
}

// An inserted frame comes in the middle between two requests.
bool comes_too_early(const SequenceFrame& frame) {
  return frame.cycle() - frame.cycle() / 2 < frame.setup().frame_gap_min;
}

}  // namespace

std::optional<long double> sequence_theory(const SequenceFrame& frame, const SequenceRow& row) {
  const std::string_view name = row.variant_name();
  const long double counter_fits = 1.0L / row.period();
  if (row.task != SequenceTask::fault) return 0;
  switch (row.kind) {
    case TransmissionError::corruption:
      return corruption_theory(frame, name);
    case TransmissionError::repetition:
      return name == "any_age" ? counter_fits : 0;
    case TransmissionError::insertion:
      return name == "foreign" && !comes_too_early(frame) ? counter_fits : 0;
    case TransmissionError::addressing:
      return name == "start_value" ? 0 : counter_fits;
    case TransmissionError::masquerade:
      if (name == "noise") return noise_theory(frame);
      if (name == "noise_word") return noise_word_theory(frame);
      if (name == "polynomial") return polynomial_theory(frame);
      return name == "standard" ? standard_theory(frame) : 0;
    case TransmissionError::sequence:
    case TransmissionError::loss:
    case TransmissionError::delay:
      return 0;
  }
  return std::nullopt;
}

double deviation_of(std::uint64_t accepted, long double expected, long double variance) {
  constexpr long double many = 1000;
  if (expected > many) {
    return static_cast<double>((static_cast<long double>(accepted) - expected) /
                               std::sqrt(variance));
  }
  if (static_cast<long double>(accepted) >= expected) return deviate(at_least(accepted, expected));
  return -deviate(at_most(accepted, expected));
}

}  // namespace biss::lab
