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

std::uint8_t bits_of(LineWord mask) {
  return static_cast<std::uint8_t>(std::popcount(static_cast<std::uint64_t>(mask)) +
                                   std::popcount(static_cast<std::uint64_t>(mask >> 64U)));
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
  const std::uint64_t cpw_refused = flag_mask(cpw.error);
  const std::uint64_t spw_refused =
      flag_mask(spw.error) | spw.life_counter.placed(~std::uint64_t{0});
  refused_ = on_line(cpw_refused, spw_refused);
  drawn_ =
      on_line(low_mask(cpw.data_bits) & ~cpw_refused,
              low_mask(spw.data_bits) & ~spw_refused & ~compared_data(low_mask(alignment.bits)));
  const std::uint64_t upper = low_mask(alignment.bits) & ~low_mask(near_compared_bits);
  far_ = on_line(pack(cpw, {.position = upper << alignment.cpw_shift}) ^ pack(cpw, {}), 0);
  const LineWord spw_word = (LineWord{1} << frame.spw_bits()) - 1U;
  append_places(drawn_ & ~far_ & ~spw_word);
  append_places(drawn_ & spw_word);
  near_places_ = places_.size();
  append_places(far_);

  const unsigned tolerance = frame.plan().setup().comparison.tolerance_lsb;
  const bool room = 2U * tolerance + 3U <= low_mask(alignment.bits);
  lowest_difference_ = std::uint64_t{0} - tolerance - (room ? 1U : 0U);
  differences_ = 2U * tolerance + (room ? 3U : 1U);

  set_shares();
  passed_ = (1 - probability_of(turned_rate)) / static_cast<long double>(differences_) *
            std::pow(1 - probability_of(refused_rate), static_cast<long double>(bits_of(refused_)));
}

void FittingDraws::append_places(LineWord bits) {
  for (; bits != 0; bits &= bits - 1U) places_.push_back(bits & -bits);
}

void FittingDraws::set_shares() {
  const auto n = static_cast<unsigned>(places_.size());
  const auto near = static_cast<unsigned>(near_places_);
  const long double wrong = probability_of(rate_);
  const auto evenly = [](unsigned places, unsigned size) {
    const unsigned most = std::min(most_chosen_bits, places);
    return size >= 1 && size <= most ? share_of_a_set(places, size) / most : 0.0L;
  };
  for (unsigned k = 0; k <= n; ++k) {
    const long double each = std::pow(wrong, static_cast<long double>(k)) *
                             std::pow(1 - wrong, static_cast<long double>(n - k));
    among_all_.push_back(each / 4 + evenly(n, k) / 4);
    among_near_.push_back(k <= near_places_ ? evenly(near, k) / 2 : 0);
  }
}

LineWord FittingDraws::on_line(std::uint64_t cpw_data, std::uint64_t spw_data) const {
  const unsigned cpw_shift = frame_.spw_bits() + frame_.cpw_format().crc.width_bits;
  return LineWord{cpw_data} << cpw_shift | LineWord{spw_data} << frame_.spw_format().crc.width_bits;
}

// The bits of the safety word's data that hold a compared value.
std::uint64_t FittingDraws::compared_data(std::uint64_t value) const {
  const ChannelFormat& spw = frame_.spw_format();
  const unsigned shift = frame_.plan().alignment().spw_shift;
  return pack(spw, {.position = value << shift}) ^ pack(spw, {});
}

// Each data bit with this rate.
LineWord FittingDraws::chosen(sim::Random& random, std::uint32_t rate) const {
  const auto word = [&] {
    return chosen_bits<std::uint64_t>(
        rate, [&random] { return random.next(); }, [](std::uint64_t open) { return open != 0; });
  };
  const std::uint64_t cpw = word() & low_mask(frame_.cpw_format().data_bits);
  return on_line(cpw, word() & low_mask(frame_.spw_format().data_bits));
}

LineWord FittingDraws::draw_set(sim::Random& random, std::size_t places) const {
  LineWord errors = 0;
  for (auto left = 1U + random.below(std::min<std::size_t>(most_chosen_bits, places)); left > 0;) {
    const LineWord place = places_[static_cast<std::size_t>(random.below(places))];
    if ((errors & place) != 0) continue;
    errors |= place;
    --left;
  }
  return errors;
}

LineWord FittingDraws::draw_some(sim::Random& random) const {
  switch (random.next() % 4U) {
    case 0:
      return chosen(random, rate_) & drawn_;
    case 1:
      return draw_set(random, places_.size());
    default:
      return draw_set(random, near_places_);
  }
}

// The safety word's bits to change, so that it differs by this from the value of the control word.
LineWord FittingDraws::fitting_bits(const SentFrame& sent, LineWord errors,
                                    std::uint64_t difference) const {
  const ChannelFormat& cpw = frame_.cpw_format();
  const safety_detail::Alignment& alignment = frame_.plan().alignment();
  const std::uint64_t mask = low_mask(alignment.bits);
  const auto cpw_errors =
      static_cast<std::uint64_t>(errors >> (frame_.spw_bits() + cpw.crc.width_bits));
  const std::uint64_t data = pack(cpw, {.position = sent.position}) ^ cpw_errors;
  const std::uint64_t read = (unpack(cpw, data).position >> alignment.cpw_shift) & mask;
  const std::uint64_t was =
      (spw_position(cpw, frame_.spw_format(), sent.position) >> alignment.spw_shift) & mask;
  return on_line(0, compared_data(((read + difference) & mask) ^ was));
}

// How these wrong data bits change the checksums.
LineWord FittingDraws::fitting_checksums(LineWord data) const {
  std::uint32_t cpw = 0;
  std::uint32_t spw = 0;
  for (unsigned bit = 0; bit < frame_.spw_bits(); ++bit) {
    if (((data >> bit) & 1U) != 0) spw ^= frame_.spw_columns()[bit];
  }
  for (unsigned bit = 0; bit < frame_.cpw_bits(); ++bit) {
    if (((data >> (frame_.spw_bits() + bit)) & 1U) != 0) cpw ^= frame_.cpw_columns()[bit];
  }
  return LineWord{cpw} << frame_.spw_bits() | spw;
}

FittingDraws::Pattern FittingDraws::draw(const SentFrame& sent, std::uint64_t seed,
                                         std::uint64_t index) const {
  sim::Random random(~seed ^ sim::scrambled(index));
  LineWord errors = draw_some(random);
  Pattern pattern;
  pattern.bits.far = bits_of(errors & far_);
  pattern.bits.near = bits_of(errors & ~far_);
  errors |= fitting_bits(sent, errors, lowest_difference_ + random.below(differences_));
  errors |= chosen(random, refused_rate) & refused_;
  pattern.wrong = errors | fitting_checksums(errors);
  pattern.bits.all = bits_of(pattern.wrong);
  const auto turned = static_cast<unsigned>(random.below(frame_.bits()));
  if (static_cast<std::uint32_t>(random.next()) < turned_rate)
    pattern.wrong ^= LineWord{1} << turned;
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
