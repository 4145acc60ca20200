// What the counts of a campaign say, beside what they should.
#pragma once

#include <optional>
#include <vector>

#include "lab/campaign_counts.hpp"
#include "lab/campaign_frame.hpp"
#include "lab/campaign_theory.hpp"

namespace biss::lab {

/// What the counts say of one Acceptance.
struct CampaignEstimate {
  /// Of a frame; by importance sampling the weighed one.
  long double rate = 0;
  /// Bounds of the rate that hold with 95 %: Wilson's for plain counts, normal for weighed ones.
  long double low = 0;
  long double high = 1;
  /// By how many standard deviations the rate is above the theory; none without a theory, or where
  /// it would mean nothing: fewer than 100 events expected, or fewer than 1000 effective ones of
  /// those that are weighed.
  std::optional<long double> sigma{};
  /// What plain sampling should have counted.
  long double expected = 0;
  /// Weighed: as many plain events would say as much, (sum of weights)^2 / sum of squares. Plain:
  /// the events.
  long double effective = 0;
};

/// Whether a fault's counts say anything of this: fitting draws know of the monitor only.
bool is_counted(const FaultChoice& fault, Acceptance what);

/// \pre is_counted(fault, what)
CampaignEstimate estimate(const CampaignFrame& frame, const FaultChoice& fault,
                          const CampaignCounts& counts, Acceptance what,
                          std::optional<long double> theory);

/// The flips to add where plain sampling would see fewer than 100 events of an Acceptance that
/// can be: the same by importance sampling. Fitting draws for the monitor, a higher rate for the
/// checksums, where that is of use.
std::vector<FaultChoice> importance_of(const CampaignFrame& frame, const FaultChoice& fault,
                                       std::uint64_t frames, const CampaignTheory& theory);

}  // namespace biss::lab
