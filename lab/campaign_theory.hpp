// The expected counts of a campaign, by exact calculation that shares no step with the campaign,
// and the rates that follow from its counts, with confidence limits.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/campaign_block.hpp"
#include "lab/residual.hpp"

namespace biss::lab {

/// The probability of each Acceptance, in its order. All words are equally likely.
using CampaignTheory = std::array<long double, acceptance_count>;

/// For any fault: by the weights of the codes for flips, by linear equations for the others.
/// \return nothing if both checksums together have more than 24 bits, or if the comparison tolerates
/// more than one count
std::optional<CampaignTheory> campaign_theory(const CampaignFrame& frame, const FaultChoice& fault);

/// Flips at any rate. The patterns are counted once, in integers; the rest is a sum of positive
/// terms, so that no digit is lost for rare events.
class FlipsTheory {
 public:
  /// \pre the conditions of campaign_theory()
  explicit FlipsTheory(const CampaignFrame& frame);

  CampaignTheory at(long double rate) const;

 private:
  Undetected cpw_;
  Undetected spw_;
  Undetected monitor_;
  Undetected wrong_;
};

/// campaign_theory() for many faults of one frame; each is calculated once.
class CampaignTheories {
 public:
  /// \pre the frame outlives this
  explicit CampaignTheories(const CampaignFrame& frame) : frame_(frame) {}

  std::optional<CampaignTheory> of(const FaultChoice& fault);

 private:
  const CampaignFrame& frame_;
  std::optional<FlipsTheory> flips_;
  std::map<std::string, CampaignTheory> placed_;
};

/// The estimate of one Acceptance.
struct CampaignEstimate {
  /// The rate of events a frame; weighted with importance sampling.
  long double rate = 0;
  /// 95 % confidence limits of the rate: Wilson limits for plain counts, normal limits for weighted
  /// ones.
  long double low = 0;
  long double high = 1;
  /// The deviation of the rate from theory in standard deviations. None without a theory, with fewer
  /// than 100 expected events, or with fewer than 1000 effective weighted events.
  std::optional<long double> sigma{};
  /// The number of events that plain sampling is expected to count.
  long double expected = 0;
  /// The number of plain events with the same information: (sum of weights)^2 / sum of squares if
  /// weighted, else the events.
  long double effective = 0;
};

/// Whether a fault has counts of this kind: fitting draws count only `monitor` and `wrong`.
bool is_counted(const FaultChoice& fault, Acceptance what);

/// \pre is_counted(fault, what)
CampaignEstimate estimate(const CampaignFrame& frame, const FaultChoice& fault,
                          const CampaignCounts& counts, Acceptance what,
                          std::optional<long double> theory);

/// Returns the rows by importance sampling to add if plain sampling would see fewer than 100 events
/// of an Acceptance: fitting draws for the monitor, a higher rate for the checksums if that helps.
std::vector<FaultChoice> importance_of(const CampaignFrame& frame, const FaultChoice& fault,
                                       std::uint64_t frames, const CampaignTheory& theory);

}  // namespace biss::lab
