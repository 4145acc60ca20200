#include "lab/campaign_theory.hpp"

#include <algorithm>
#include <cmath>

#include "lab/campaign_fitting.hpp"
#include "lab/pair.hpp"
#include "lab/statistics.hpp"
#include "lab/structure.hpp"
#include "lab/weights.hpp"

namespace biss::lab {
namespace {

Undetected undetected_by(const ChannelFormat& word) {
  return undetected_of(weights_of(code_of(word)));
}

// The probability that no bit is wrong.
long double intact(const Undetected& word, long double rate) {
  return std::pow(1 - rate, static_cast<long double>(word.size() - 1));
}

constexpr long double enough_events = 100;
constexpr long double enough_effective = 1000;

// The likelihood ratio of a pattern with this number of wrong bits.
long double ratio(const FaultChoice& fault, unsigned bits, std::size_t weight) {
  if (fault.drawn_rate == 0) return 1;
  const long double rate = probability_of(fault.rate);
  const long double drawn = probability_of(fault.drawn_rate);
  return std::pow(rate / drawn, static_cast<long double>(weight)) *
         std::pow((1 - rate) / (1 - drawn), static_cast<long double>(bits - weight));
}

struct WeightedEvents {
  long double sum = 0;
  long double squares = 0;

  void add(long double each, std::uint64_t events) {
    sum += each * static_cast<long double>(events);
    squares += each * each * static_cast<long double>(events);
  }
};

WeightedEvents weighted(const CampaignFrame& frame, const FaultChoice& fault,
                        const CampaignCounts& counts, Acceptance what) {
  WeightedEvents events;
  const unsigned bits = bits_of(frame, what);
  for (std::size_t weight = 0; weight < weight_count; ++weight) {
    const std::uint64_t number = counts.accepted[static_cast<std::size_t>(what)][weight];
    if (number != 0) events.add(ratio(fault, bits, weight), number);
  }
  if (!fault.fitting) return events;
  const FittingDraws draws(frame, fault.rate);
  for (const auto& [bin, number] : counts.fitted) {
    if (bin.what == what) events.add(draws.likelihood_ratio(bin.bits), number);
  }
  return events;
}

}  // namespace

FlipsTheory::FlipsTheory(const CampaignFrame& frame)
    : cpw_(undetected_by(frame.cpw_format())), spw_(undetected_by(frame.spw_format())) {
  PairWeights pair = pair_weights(frame.format(), frame.plan().setup().comparison);
  monitor_ = std::move(pair.accepted);
  wrong_ = std::move(pair.wrong);
}

CampaignTheory FlipsTheory::at(long double rate) const {
  const long double cpw = probability(cpw_, rate);
  const long double spw = probability(spw_, rate);
  const long double both = cpw * spw + cpw * intact(spw_, rate) + intact(cpw_, rate) * spw;
  return {cpw, spw, both, probability(monitor_, rate), probability(wrong_, rate)};
}

std::optional<CampaignTheory> CampaignTheories::of(const FaultChoice& fault) {
  if (pair_problem(frame_.format(), frame_.plan().setup().comparison)) return std::nullopt;
  if (fault.kind == FaultKind::flips) {
    if (!flips_) flips_.emplace(frame_);
    return flips_->at(probability_of(fault.rate));
  }
  const auto [at, fresh] = placed_.try_emplace(text_of(fault));
  if (fresh) at->second = accepted_shares(frame_.format(), frame_.plan().setup(), fault);
  return at->second;
}

std::optional<CampaignTheory> campaign_theory(const CampaignFrame& frame,
                                              const FaultChoice& fault) {
  return CampaignTheories(frame).of(fault);
}

bool is_counted(const FaultChoice& fault, Acceptance what) {
  return !fault.fitting || what == Acceptance::monitor || what == Acceptance::wrong;
}

CampaignEstimate estimate(const CampaignFrame& frame, const FaultChoice& fault,
                          const CampaignCounts& counts, Acceptance what,
                          std::optional<long double> theory) {
  CampaignEstimate found;
  if (counts.frames == 0) return found;
  const auto frames = static_cast<long double>(counts.frames);
  const auto [sum, squares] = weighted(frame, fault, counts, what);
  found.rate = sum / frames;
  found.effective = squares > 0 ? sum * sum / squares : 0;
  if (theory) found.expected = *theory * frames;
  long double deviation = 0;
  if (!fault.weighted()) {
    const ShareLimits limits = wilson_limits(found.rate, frames);
    found.low = limits.low;
    found.high = limits.high;
    if (theory && found.expected >= enough_events) {
      deviation = std::sqrt(*theory * (1 - *theory) / frames);
    }
  } else {
    deviation = std::sqrt(std::max(0.0L, squares / frames - found.rate * found.rate) / frames);
    found.low = std::max(0.0L, found.rate - two_sided_95 * deviation);
    found.high = found.effective == 0 ? 1 : found.rate + two_sided_95 * deviation;
    if (found.effective < enough_effective) deviation = 0;
  }
  if (theory && deviation > 0) found.sigma = (found.rate - *theory) / deviation;
  return found;
}

std::vector<FaultChoice> importance_of(const CampaignFrame& frame, const FaultChoice& fault,
                                       std::uint64_t frames, const CampaignTheory& theory) {
  if (fault.kind != FaultKind::flips || fault.weighted()) return {};
  const auto is_rare = [&](Acceptance what) {
    const long double share = theory[static_cast<std::size_t>(what)];
    return share * static_cast<long double>(frames) < enough_events;
  };
  std::vector<FaultChoice> added;
  // Six wrong bits in the safety word are the fewest that its checksum does not detect.
  const double drawn = 6.0 / frame.spw_bits();
  if ((is_rare(Acceptance::cpw) || is_rare(Acceptance::spw) || is_rare(Acceptance::both)) &&
      2 * static_cast<double>(probability_of(fault.rate)) <= drawn) {
    added.push_back(fault);
    added.back().drawn_rate = static_cast<std::uint32_t>(drawn * 4294967296.0);
  }
  if (is_rare(Acceptance::monitor) || is_rare(Acceptance::wrong)) {
    added.push_back(fault);
    added.back().fitting = true;
  }
  return added;
}

}  // namespace biss::lab
