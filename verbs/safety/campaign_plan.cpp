#include "verbs/safety/campaign_plan.hpp"

#include <fmt/format.h>

#include "lab/campaign_theory.hpp"
#include "verbs/common/safety_format.hpp"

namespace biss::verbs {

const std::vector<std::string>& usual_campaign_faults() {
  static const std::vector<std::string> faults{
      "flips:0.5",   "flips:0.1",  "flips:0.01",  "burst:16",     "burst:32",      "lost_bit",
      "doubled_bit", "slo_low",    "slo_high",    "inserted_low", "inserted_high", "gap_low:8",
      "gap_high:8",  "lost_start", "false_start", "cds_high",     "stop_high"};
  return faults;
}

std::optional<lab::CampaignFrame> campaign_frame_of(const std::string& name) {
  const auto known = parse_safety_format(name);
  if (!known) return std::nullopt;
  return lab::CampaignFrame::make(known->format, known->setup);
}

std::string campaign_rules(const lab::CampaignFrame& frame) {
  const SafetySetup& setup = frame.plan().setup();
  return fmt::format("compared bits {}, of them turns {}, tolerance {}, counter from {}",
                     frame.plan().alignment().bits,
                     frame.plan().alignment().bits - frame.plan().alignment().singleturn_bits,
                     setup.comparison.tolerance_lsb, frame.first_counter());
}

bool add_campaign_fault(const lab::CampaignFrame& frame, const std::string& text,
                        lab::CampaignPlan& plan) {
  const auto fault = lab::parse_fault(text);
  if (!fault) return false;
  if (fault->place.value_or(0) >= lab::places_of(*fault, frame.bits())) return false;
  plan.faults.push_back(*fault);
  return true;
}

void add_importance(const lab::CampaignFrame& frame, lab::CampaignPlan& plan) {
  const std::vector<lab::FaultChoice> asked = plan.faults;
  lab::CampaignTheories theories(frame);
  for (const lab::FaultChoice& fault : asked) {
    if (fault.kind != lab::FaultKind::flips) continue;
    const auto theory = theories.of(fault);
    if (!theory) continue;
    const auto weighed = lab::importance_of(frame, fault, plan.frames, *theory);
    plan.faults.insert(plan.faults.end(), weighed.begin(), weighed.end());
  }
}

}  // namespace biss::verbs
