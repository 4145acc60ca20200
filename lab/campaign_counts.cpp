#include "lab/campaign_counts.hpp"

#include <algorithm>
#include <numeric>

namespace biss::lab {

void CampaignCounts::add_missed(std::uint64_t index) {
  const auto place = std::lower_bound(missed.begin(), missed.end(), index);
  if (place == missed.end() && missed.size() == missed_kept) return;
  missed.insert(place, index);
  if (missed.size() > missed_kept) missed.pop_back();
}

void CampaignCounts::add(const CampaignCounts& other) {
  frames += other.frames;
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    for (std::size_t weight = 0; weight < weight_count; ++weight) {
      accepted[what][weight] += other.accepted[what][weight];
    }
  }
  for (const auto& [bin, events] : other.fitted) fitted[bin] += events;
  for (const std::uint64_t index : other.missed) add_missed(index);
}

std::uint64_t CampaignCounts::total(Acceptance what) const {
  const auto& counts = accepted[static_cast<std::size_t>(what)];
  std::uint64_t sum = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  for (const auto& [bin, events] : fitted) {
    if (bin.what == what) sum += events;
  }
  return sum;
}

}  // namespace biss::lab
