#include "lab/campaign_fitting.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace biss::lab {
namespace {

constexpr unsigned most_chosen_bits = 6;
// A carry of one count rarely goes further.
constexpr unsigned near_compared_bits = 3;
// Parts of 2^32: nE or a counter bit wrong; one additional bit flipped.
constexpr std::uint32_t refused_rate = 1U << 27U;
constexpr std::uint32_t turned_rate = 1U << 29U;

std::uint64_t flag_mask(const FlagField& flag) {
  return flag.present ? std::uint64_t{1} << flag.shift : 0;
}

// Bits that are 1 with a probability of rate / 2^32 each; see LaneRandom::chosen().
std::uint64_t chosen(sim::Random& random, std::uint32_t rate) {
  std::uint64_t open = ~std::uint64_t{0};
  std::uint64_t below = 0;
  for (; rate != 0 && open != 0; rate <<= 1U) {
    const std::uint64_t drawn = random.next();
    if ((rate >> 31U) != 0) {
      below |= open & ~drawn;
      open &= drawn;
    } else {
      open &= ~drawn;
    }
  }
  return below;
}

std::uint8_t bits_of(std::uint64_t mask) { return static_cast<std::uint8_t>(std::popcount(mask)); }

// How these wrong data bits change the checksum.
std::uint64_t fitting_crc(const std::vector<std::uint32_t>& columns, unsigned width,
                          std::uint64_t data) {
  std::uint64_t crc = 0;
  for (; data != 0; data &= data - 1U) {
    crc ^= columns[width + static_cast<unsigned>(std::countr_zero(data))];
  }
  return crc;
}

// 1 divided by the number of sets of k out of n.
long double share_of_a_set(unsigned n, unsigned k) {
  long double share = 1;
  for (unsigned i = 1; i <= k; ++i) share *= static_cast<long double>(i) / (n - i + 1U);
  return share;
}

}  // namespace

FittingDraws::FittingDraws(const CampaignFrame& frame, std::uint32_t rate)
    : frame_(frame), rate_(rate) {
  const ChannelFormat& cpw = frame.cpw_format();
  const ChannelFormat& spw = frame.spw_format();
  const safety_detail::Alignment& alignment = frame.plan().alignment();
  cpw_.refused = flag_mask(cpw.error);
  cpw_.drawn = low_mask(cpw.data_bits) & ~cpw_.refused;
  spw_.refused = flag_mask(spw.error) | spw.life_counter.placed(~std::uint64_t{0});
  const std::uint64_t compared = compared_data(low_mask(alignment.bits));
  spw_.drawn = low_mask(spw.data_bits) & ~spw_.refused & ~compared;
  const std::uint64_t upper = low_mask(alignment.bits) & ~low_mask(near_compared_bits);
  far_ = pack(cpw, {.position = upper << alignment.cpw_shift}) ^ pack(cpw, {});
  append_places(cpw_.drawn & ~far_, spw_.drawn);
  near_places_ = static_cast<unsigned>(places_.size());
  append_places(far_, 0);

  const unsigned tolerance = frame.plan().setup().comparison.tolerance_lsb;
  const bool room = 2U * tolerance + 3U <= low_mask(alignment.bits);
  lowest_difference_ = std::uint64_t{0} - tolerance - (room ? 1U : 0U);
  differences_ = 2U * tolerance + (room ? 3U : 1U);

  set_shares();
  passed_ = (1 - probability_of(turned_rate)) / static_cast<long double>(differences_) *
            std::pow(1 - probability_of(refused_rate),
                     static_cast<long double>(bits_of(cpw_.refused) + bits_of(spw_.refused)));
}

void FittingDraws::append_places(std::uint64_t cpw, std::uint64_t spw) {
  for (; cpw != 0; cpw &= cpw - 1U) places_.push_back({cpw & -cpw, 0});
  for (; spw != 0; spw &= spw - 1U) places_.push_back({0, spw & -spw});
}

void FittingDraws::set_shares() {
  const auto n = static_cast<unsigned>(places_.size());
  const long double wrong = probability_of(rate_);
  const auto evenly = [](unsigned places, unsigned size) {
    const unsigned most = std::min(most_chosen_bits, places);
    return size >= 1 && size <= most ? share_of_a_set(places, size) / most : 0.0L;
  };
  for (unsigned k = 0; k <= n; ++k) {
    const long double each = std::pow(wrong, static_cast<long double>(k)) *
                             std::pow(1 - wrong, static_cast<long double>(n - k));
    among_all_.push_back(each / 4 + evenly(n, k) / 4);
    among_near_.push_back(k <= near_places_ ? evenly(near_places_, k) / 2 : 0);
  }
}

// The bits of the safety word's data that hold a compared value.
std::uint64_t FittingDraws::compared_data(std::uint64_t value) const {
  const ChannelFormat& spw = frame_.spw_format();
  const unsigned shift = frame_.plan().alignment().spw_shift;
  return pack(spw, {.position = value << shift}) ^ pack(spw, {});
}

FittingDraws::DataErrors FittingDraws::draw_set(sim::Random& random, unsigned places) const {
  DataErrors errors;
  for (auto left = 1U + random.below(std::min(most_chosen_bits, places)); left > 0;) {
    const DataErrors& place = places_[static_cast<std::size_t>(random.below(places))];
    if (((errors.cpw & place.cpw) | (errors.spw & place.spw)) != 0) continue;
    errors.cpw |= place.cpw;
    errors.spw |= place.spw;
    --left;
  }
  return errors;
}

FittingDraws::DataErrors FittingDraws::draw_some(sim::Random& random) const {
  switch (random.next() % 4U) {
    case 0: {
      const std::uint64_t cpw = chosen(random, rate_) & cpw_.drawn;
      return {cpw, chosen(random, rate_) & spw_.drawn};
    }
    case 1:
      return draw_set(random, static_cast<unsigned>(places_.size()));
    default:
      return draw_set(random, near_places_);
  }
}

std::uint64_t FittingDraws::fitting_bits(const SentFrame& sent, std::uint64_t cpw_errors,
                                         std::uint64_t difference) const {
  const ChannelFormat& cpw = frame_.cpw_format();
  const safety_detail::Alignment& alignment = frame_.plan().alignment();
  const std::uint64_t mask = low_mask(alignment.bits);
  const std::uint64_t data = pack(cpw, {.position = sent.position}) ^ cpw_errors;
  const std::uint64_t read = (unpack(cpw, data).position >> alignment.cpw_shift) & mask;
  const std::uint64_t was =
      (spw_position(cpw, frame_.spw_format(), sent.position) >> alignment.spw_shift) & mask;
  return compared_data(((read + difference) & mask) ^ was);
}

FittingDraws::Pattern FittingDraws::draw(const SentFrame& sent, std::uint64_t seed,
                                         std::uint64_t index) const {
  sim::Random random(~seed ^ sim::scrambled(index));
  DataErrors errors = draw_some(random);
  Pattern pattern;
  pattern.bits.far = bits_of(errors.cpw & far_);
  pattern.bits.near = static_cast<std::uint8_t>(bits_of(errors.cpw & ~far_) + bits_of(errors.spw));
  const std::uint64_t difference = lowest_difference_ + random.below(differences_);
  errors.spw |= fitting_bits(sent, errors.cpw, difference);
  errors.cpw |= chosen(random, refused_rate) & cpw_.refused;
  errors.spw |= chosen(random, refused_rate) & spw_.refused;
  const unsigned cpw_width = frame_.cpw_format().crc.width_bits;
  const unsigned spw_width = frame_.spw_format().crc.width_bits;
  pattern.cpw = errors.cpw << cpw_width | fitting_crc(frame_.cpw_columns(), cpw_width, errors.cpw);
  pattern.spw = errors.spw << spw_width | fitting_crc(frame_.spw_columns(), spw_width, errors.spw);
  pattern.bits.all = static_cast<std::uint8_t>(bits_of(pattern.cpw) + bits_of(pattern.spw));
  const auto turned = static_cast<unsigned>(random.below(frame_.bits()));
  if (static_cast<std::uint32_t>(random.next()) < turned_rate) {
    (turned < frame_.spw_bits() ? pattern.spw : pattern.cpw) ^=
        std::uint64_t{1} << (turned < frame_.spw_bits() ? turned : turned - frame_.spw_bits());
  }
  return pattern;
}

long double FittingDraws::likelihood_ratio(const FittedBits& bits) const {
  const std::size_t drawn_bits = std::size_t{bits.far} + bits.near;
  const unsigned all = frame_.bits();
  if (drawn_bits >= among_all_.size() || bits.all > all) return 0;
  const long double drawn = among_all_[drawn_bits] + (bits.far == 0 ? among_near_[drawn_bits] : 0);
  const long double rate = probability_of(rate_);
  return std::pow(rate, static_cast<long double>(bits.all)) *
         std::pow(1 - rate, static_cast<long double>(all - bits.all)) / (drawn * passed_);
}

}  // namespace biss::lab
