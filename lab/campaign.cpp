#include "lab/campaign.hpp"

namespace biss::lab {

bool run_campaign(const CampaignFrame& frame, CampaignState& state, const ExperimentRun& run) {
  return run_experiment(state.rows, run, [&](std::size_t row, std::uint64_t block) {
    return count_block(frame, {state.plan.faults[row], state.plan.seed}, block,
                       state.rows[row].blocks.size_of(block));
  });
}

bool fits(const CampaignFrame& frame, const CampaignState& state) {
  const auto bits_of = [&](Acceptance what) {
    if (what == Acceptance::cpw) return frame.cpw_bits();
    return what == Acceptance::spw ? frame.spw_bits() : frame.bits();
  };
  for (const auto& row : state.rows) {
    for (std::size_t what = 0; what < acceptance_count; ++what) {
      const auto& counts = row.counts.accepted[what];
      for (std::size_t weight = bits_of(static_cast<Acceptance>(what)) + 1U; weight < weight_count;
           ++weight) {
        if (counts[weight] != 0) return false;
      }
    }
    for (const auto& [bin, events] : row.counts.fitted) {
      const unsigned drawn = unsigned{bin.bits.far} + bin.bits.near;
      if (bin.bits.all > frame.bits() || drawn > frame.bits()) return false;
    }
  }
  return true;
}

}  // namespace biss::lab
