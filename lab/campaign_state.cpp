// A campaign's state as text: what was planned, what is done, what was counted.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "lab/campaign.hpp"

namespace biss::lab {
namespace {

using Json = nlohmann::json;

constexpr int state_version = 2;

// Runs of finished blocks, [first, behind the last].
Json runs_of(const std::vector<bool>& done) {
  Json runs = Json::array();
  for (std::size_t block = 0; block < done.size();) {
    if (!done[block]) {
      ++block;
      continue;
    }
    std::size_t behind = block;
    while (behind < done.size() && done[behind]) ++behind;
    runs.push_back({block, behind});
    block = behind;
  }
  return runs;
}

Json counts_object(const CampaignCounts& counts) {
  Json object;
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    Json events = Json::array();
    for (std::size_t weight = 0; weight < weight_count; ++weight) {
      if (const std::uint64_t count = counts.accepted[what][weight]) {
        events.push_back({weight, count});
      }
    }
    object[std::string(acceptance_names[what])] = events;
  }
  return object;
}

Json fitted_list(const CampaignCounts& counts) {
  Json list = Json::array();
  for (const auto& [bin, events] : counts.fitted) {
    list.push_back({acceptance_names[static_cast<std::size_t>(bin.what)], bin.bits.far,
                    bin.bits.near, bin.bits.all, events});
  }
  return list;
}

FittedBin bin_of(const Json& entry) {
  const std::string name = entry.at(0);
  const auto what = std::find(acceptance_names.begin(), acceptance_names.end(), name);
  if (what == acceptance_names.end()) throw std::out_of_range(name);
  return {static_cast<Acceptance>(what - acceptance_names.begin()),
          {entry.at(1), entry.at(2), entry.at(3)}};
}

CampaignCounts counts_of(const Json& fault) {
  CampaignCounts counts;
  counts.frames = fault.at("frames");
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    for (const Json& event : fault.at("accepted").at(std::string(acceptance_names[what]))) {
      counts.accepted[what].at(event.at(0).get<std::size_t>()) = event.at(1);
    }
  }
  for (const Json& entry : fault.at("fitted")) counts.fitted[bin_of(entry)] = entry.at(4);
  for (const std::uint64_t index : fault.at("missed").get<std::vector<std::uint64_t>>()) {
    counts.add_missed(index);
  }
  return counts;
}

std::optional<CampaignPlan> plan_of(const Json& object) {
  CampaignPlan plan;
  plan.format = object.at("format");
  plan.rules = object.at("rules");
  plan.seed = object.at("seed");
  plan.frames = object.at("frames");
  for (const Json& fault : object.at("faults")) {
    const auto choice = parse_fault(fault.at("fault").get<std::string>());
    if (!choice) return std::nullopt;
    plan.faults.push_back(*choice);
  }
  if (plan.frames > max_campaign_frames) return std::nullopt;
  return plan;
}

// False where blocks and frames do not belong together.
bool fill(CampaignState& state, const Json& object) {
  for (std::size_t n = 0; n < state.plan.faults.size(); ++n) {
    const Json& fault = object.at("faults").at(n);
    state.counts[n] = counts_of(fault);
    std::uint64_t frames = 0;
    for (const Json& run : fault.at("blocks")) {
      const std::uint64_t behind = run.at(1);
      if (behind > state.done[n].size()) return false;
      for (std::uint64_t block = run.at(0); block < behind; ++block) {
        if (!state.done[n][block]) frames += state.plan.frames_of_block(n, block);
        state.done[n][block] = true;
      }
    }
    if (frames != state.counts[n].frames) return false;
  }
  return true;
}

}  // namespace

std::string state_text(const CampaignState& state) {
  Json object = {{"biss_campaign", state_version},
                 {"format", state.plan.format},
                 {"rules", state.plan.rules},
                 {"seed", state.plan.seed},
                 {"frames", state.plan.frames}};
  Json faults = Json::array();
  for (std::size_t n = 0; n < state.plan.faults.size(); ++n) {
    faults.push_back({{"fault", text_of(state.plan.faults[n])},
                      {"frames", state.counts[n].frames},
                      {"blocks", runs_of(state.done[n])},
                      {"accepted", counts_object(state.counts[n])},
                      {"fitted", fitted_list(state.counts[n])},
                      {"missed", state.counts[n].missed}});
  }
  object["faults"] = faults;
  return object.dump() + "\n";
}

std::optional<CampaignState> read_state(const std::string& text) {
  try {
    const Json object = Json::parse(text);
    if (object.at("biss_campaign") != state_version) return std::nullopt;
    auto plan = plan_of(object);
    if (!plan) return std::nullopt;
    CampaignState state(std::move(*plan));
    if (!fill(state, object)) return std::nullopt;
    return state;
  } catch (const std::exception&) {  // not JSON, a field missing or of another kind
    return std::nullopt;
  }
}

}  // namespace biss::lab
