// Wrong bits drawn so that they fit the checks: importance sampling for what no plain campaign ever
// sees, a damaged frame that the whole monitor accepts.
#pragma once

#include <cstdint>
#include <vector>

#include "lab/campaign_block.hpp"
#include "sim/random.hpp"

namespace biss::lab {

/// One draw after the other:
/// * bits of the control word's data (not nE), and those of the safety word's data that nothing is
///   compared with (not nE, not the counter): in a quarter of the draws each is wrong with the
///   fault's rate; in another quarter 1 to 6 of them are, every set of that size alike; in half of
///   the draws 1 to 6 of those that no comparison sees, or see only as the last bits of a count:
///   all but the control word's compared bits from the fourth one on;
/// * the safety word's compared bits are made to read what the control word's then read, plus a
///   difference that is drawn evenly from one count more than is tolerated on either side;
/// * nE and the counter are wrong with 1/32 a bit, and so refused;
/// * both checksums fit, but for one frame in eight in which any one bit is turned as well.
///
/// A frame that a right monitor accepts is reached in up to three ways, so that how likely it was
/// drawn is a sum of as many terms; it depends on a few numbers of bits only.
class FittingDraws {
 public:
  struct Pattern {
    /// Right-aligned as in WordPair: 1 is a wrong bit.
    std::uint64_t cpw = 0;
    std::uint64_t spw = 0;
    /// By which its weight is known.
    FittedBits bits{};
  };

  /// \param rate of a bit to be wrong in the campaign, a part of 2^32
  FittingDraws(const CampaignFrame& frame, std::uint32_t rate);

  /// What happens to this frame. The same numbers give the same bits.
  Pattern draw(const SentFrame& sent, std::uint64_t seed, std::uint64_t index) const;

  /// How much likelier the fault makes an accepted pattern than it is drawn; 0 where no draw has
  /// these numbers.
  long double likelihood_ratio(const FittedBits& bits) const;

 private:
  // A word's data bits: from the last one, the checksum not counted.
  struct Word {
    std::uint64_t drawn = 0;
    std::uint64_t refused = 0;  // nE, counter
  };
  struct DataErrors {
    std::uint64_t cpw = 0;
    std::uint64_t spw = 0;
  };

  DataErrors draw_some(sim::Random& random) const;
  DataErrors draw_set(sim::Random& random, unsigned places) const;
  std::uint64_t compared_data(std::uint64_t value) const;
  std::uint64_t fitting_bits(const SentFrame& sent, std::uint64_t cpw_errors,
                             std::uint64_t difference) const;

  void append_places(std::uint64_t cpw, std::uint64_t spw);
  void set_shares();

  const CampaignFrame& frame_;
  std::uint32_t rate_;
  Word cpw_;
  Word spw_;
  // The control word's compared bits but the lowest ones.
  std::uint64_t far_ = 0;
  // The drawn bits, those in far_ last.
  std::vector<DataErrors> places_;
  unsigned near_places_ = 0;
  std::uint64_t differences_ = 1;
  std::uint64_t lowest_difference_ = 0;
  // [k]: that this very set of k wrong bits comes, from the draws that know all places; and from
  // those that are confined to the near ones.
  std::vector<long double> among_all_;
  std::vector<long double> among_near_;
  // Of all else that has to happen for a frame to be accepted.
  long double passed_ = 1;
};

}  // namespace biss::lab
