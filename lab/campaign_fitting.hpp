// Wrong bits drawn so that they pass the checks: importance sampling for frames that no plain
// campaign sees, because the whole monitor accepts them.
#pragma once

#include <cstdint>
#include <vector>

#include "lab/campaign_block.hpp"
#include "sim/random.hpp"

namespace biss::lab {

/// Each draw has these steps:
/// * Bits of the control word's data (not nE) are wrong, and bits of the safety word's data that are
///   not compared (not nE, not the counter). In a quarter of the draws each is wrong with the fault's
///   rate; in another quarter 1 to 6 of them are wrong, every set of that size equally likely; in
///   half of the draws 1 to 6 of the near bits: all without the control word's compared bits from
///   the fourth one on.
/// * The safety word's compared bits are changed to the value that the control word's then have,
///   plus a difference that is drawn evenly, up to one count more than the tolerance in both
///   directions.
/// * nE and the counter's bits are wrong with 1/32 each, and the frame is then refused.
/// * Both checksums fit. In one frame of eight, any one bit is flipped in addition.
///
/// A frame that a correct monitor accepts is reached in up to three ways, so its probability is a
/// sum of as many terms. It depends on a few numbers of bits only.
class FittingDraws {
 public:
  struct Pattern {
    /// The wrong bits of both words; bit 0 is the last bit of the safety word.
    LineWord wrong = 0;
    /// They determine its weight.
    FittedBits bits{};
  };

  /// \param rate of a bit to be wrong in the campaign, a part of 2^32
  FittingDraws(const CampaignFrame& frame, std::uint32_t rate);

  /// The wrong bits of this frame. The same numbers give the same bits.
  Pattern draw(const SentFrame& sent, std::uint64_t seed, std::uint64_t index) const;

  /// The probability of an accepted pattern with the fault, divided by the probability with which it
  /// is drawn; 0 if no draw has these numbers.
  long double likelihood_ratio(const FittedBits& bits) const;

 private:
  LineWord draw_some(sim::Random& random) const;
  LineWord draw_set(sim::Random& random, std::size_t places) const;
  LineWord chosen(sim::Random& random, std::uint32_t rate) const;
  LineWord on_line(std::uint64_t cpw_data, std::uint64_t spw_data) const;
  std::uint64_t compared_data(std::uint64_t value) const;
  LineWord fitting_bits(const SentFrame& sent, LineWord errors, std::uint64_t difference) const;
  LineWord fitting_checksums(LineWord data) const;
  void append_places(LineWord bits);
  void set_shares();

  const CampaignFrame& frame_;
  std::uint32_t rate_;
  // Bits as in Pattern::wrong.
  LineWord drawn_ = 0;
  LineWord refused_ = 0;  // nE, counter
  // The control word's compared bits without the lowest ones.
  LineWord far_ = 0;
  // The drawn bits, those in far_ last.
  std::vector<LineWord> places_;
  std::size_t near_places_ = 0;
  std::uint64_t differences_ = 1;
  std::uint64_t lowest_difference_ = 0;
  // [k]: the probability of one set of k wrong bits, in draws from all places and in draws from the
  // near places.
  std::vector<long double> among_all_;
  std::vector<long double> among_near_;
  // The probability of the other conditions for an accepted frame.
  long double passed_ = 1;
};

}  // namespace biss::lab
