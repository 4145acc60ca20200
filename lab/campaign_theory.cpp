#include "lab/campaign_theory.hpp"

#include <cmath>

#include "lab/pair_checks.hpp"
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

}  // namespace

FlipsTheory::FlipsTheory(const CampaignFrame& frame)
    : cpw_(undetected_by(frame.cpw_format())), spw_(undetected_by(frame.spw_format())) {
  PairWeights pair = pair_weights(frame.format(), pair_checks_of(frame.plan().setup()));
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
  if (pair_problem(frame_.format(), pair_checks_of(frame_.plan().setup()))) return std::nullopt;
  if (fault.kind == CampaignFault::flips) {
    if (!flips_) flips_.emplace(frame_);
    return flips_->at(probability_of(fault.rate));
  }
  const auto [at, fresh] = placed_.try_emplace(text_of(fault));
  if (fresh) at->second = placed_theory(frame_, fault);
  return at->second;
}

std::optional<CampaignTheory> campaign_theory(const CampaignFrame& frame,
                                              const FaultChoice& fault) {
  return CampaignTheories(frame).of(fault);
}

}  // namespace biss::lab
