#include "lab/sequence_counts.hpp"

#include <algorithm>
#include <numeric>

namespace biss::lab {

std::uint64_t SequenceCounts::recognised() const {
  return std::accumulate(verdicts.begin(), verdicts.end(), std::uint64_t{0});
}

void SequenceCounts::add_odd(std::uint64_t index) {
  const auto place = std::lower_bound(odd.begin(), odd.end(), index);
  if (place != odd.end() && *place == index) return;
  if (place == odd.end() && odd.size() == odd_kept) return;
  odd.insert(place, index);
  if (odd.size() > odd_kept) odd.pop_back();
}

void SequenceCounts::add(const SequenceCounts& other) {
  frames += other.frames;
  false_alarms += other.false_alarms;
  misread += other.misread;
  position_wraps += other.position_wraps;
  counter_wraps += other.counter_wraps;
  events += other.events;
  accepted += other.accepted;
  wrong += other.wrong;
  late += other.late;
  unexpected += other.unexpected;
  for (std::size_t k = 0; k < verdicts.size(); ++k) verdicts[k] += other.verdicts[k];
  worst_cycles = std::max(worst_cycles, other.worst_cycles);
  for (const std::uint64_t index : other.odd) add_odd(index);
}

}  // namespace biss::lab
