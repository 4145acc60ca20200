// The state of a campaign, and the same as text: the plan, the blocks that are done, the counts.
#include "lab/campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

namespace biss::lab {
namespace {

using Json = nlohmann::json;

constexpr std::uint64_t state_version = 2;

Json json_of(const FaultChoice& fault, const ExperimentRow<CampaignCounts>& row) {
  Json accepted;
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    Json& events = accepted[std::string(acceptance_names[what])] = Json::array();
    for (std::size_t weight = 0; weight < weight_count; ++weight) {
      const std::uint64_t count = row.counts.accepted[what][weight];
      if (count != 0) events.push_back({weight, count});
    }
  }
  Json blocks = Json::array();
  for (const auto& run : row.done) blocks.push_back({run.lower(), run.upper()});
  Json fitted = Json::array();
  for (const auto& [bin, events] : row.counts.fitted) {
    const std::string_view what = acceptance_names[static_cast<std::size_t>(bin.what)];
    fitted.push_back({what, bin.bits.far, bin.bits.near, bin.bits.all, events});
  }
  return {{"accepted", accepted},        {"blocks", blocks},
          {"fault", text_of(fault)},     {"fitted", fitted},
          {"frames", row.counts.frames}, {"missed", row.counts.missed}};
}

struct Refused {
  std::string cause;
};

template <class... Arguments>
void require(bool holds, fmt::format_string<Arguments...> cause, Arguments&&... arguments) {
  if (!holds) throw Refused{fmt::format(cause, std::forward<Arguments>(arguments)...)};
}

const Json& member(const Json& object, const char* name) {
  const auto at = object.find(name);
  require(at != object.end(), "'{}' is missing", name);
  return *at;
}

const Json& list(const Json& value, const char* name) {
  require(value.is_array(), "'{}' is not a list", name);
  return value;
}

// For a message: one line, not long. \pre the value is a text or a number
std::string shown(const Json& value) { return value.dump(-1, ' ', true).substr(0, 40); }

std::string text(const Json& object, const char* name) {
  const Json& value = member(object, name);
  require(value.is_string(), "'{}' is not a text", name);
  return value.get<std::string>();
}

std::uint64_t number(const Json& value, const char* name, std::uint64_t most) {
  require(value.is_number(), "'{}' is not a number", name);
  require(value.is_number_unsigned() && value.get<std::uint64_t>() <= most,
          "'{}' is {}, not a whole number from 0 to {}", name, shown(value), most);
  return value.get<std::uint64_t>();
}

std::uint64_t number(const Json& object, const char* name) {
  return number(member(object, name), name, std::numeric_limits<std::uint64_t>::max());
}

void require_size(const Json& entry, const char* name, std::size_t size) {
  require(entry.is_array() && entry.size() == size, "'{}' has an entry without {} values", name,
          size);
}

BlockSet read_blocks(const Json& object, const TrialBlocks& blocks) {
  BlockSet done;
  std::uint64_t before = 0;
  for (const Json& run : list(member(object, "blocks"), "blocks")) {
    require_size(run, "blocks", 2);
    const std::uint64_t first = number(run[0], "blocks", blocks.count());
    const std::uint64_t end = number(run[1], "blocks", blocks.count());
    require(before <= first && first < end, "'blocks' are not in ascending order at [{},{}]", first,
            end);
    done.add({first, end});
    before = end;
  }
  return done;
}

void read_accepted(CampaignCounts& counts, const Json& object, bool by_weight) {
  const Json& accepted = member(object, "accepted");
  for (std::size_t what = 0; what < acceptance_count; ++what) {
    const char* name = acceptance_names[what].data();
    std::uint64_t total = 0;
    for (const Json& entry : list(member(accepted, name), name)) {
      require_size(entry, name, 2);
      const std::uint64_t weight = number(entry[0], name, by_weight ? weight_count - 1U : 0U);
      const std::uint64_t count = number(entry[1], name, counts.frames - total);
      require(counts.accepted[what][weight] == 0, "'{}' has the weight {} twice", name, weight);
      counts.accepted[what][weight] = count;
      total += count;
    }
  }
  for (std::size_t weight = 0; weight < weight_count; ++weight) {
    require(counts.accepted[4][weight] <= counts.accepted[3][weight],
            "'wrong' has more frames than 'monitor'");
  }
}

void read_fitted(CampaignCounts& counts, const Json& object) {
  std::array<std::uint64_t, acceptance_count> total{};
  for (const Json& entry : list(member(object, "fitted"), "fitted")) {
    require_size(entry, "fitted", 5);
    const bool wrong = entry[0] == "wrong";
    require(wrong || entry[0] == "monitor", "'fitted' has an entry of an unknown kind");
    const auto bits = [&entry](std::size_t n) {
      return static_cast<std::uint8_t>(number(entry[n], "fitted", weight_count - 1U));
    };
    const FittedBin bin{wrong ? Acceptance::wrong : Acceptance::monitor,
                        {bits(1), bits(2), bits(3)}};
    std::uint64_t& sum = total[static_cast<std::size_t>(bin.what)];
    const std::uint64_t count = number(entry[4], "fitted", counts.frames - sum);
    require(counts.fitted.emplace(bin, count).second, "'fitted' has an entry twice");
    sum += count;
  }
  for (const auto& [bin, count] : counts.fitted) {
    if (bin.what != Acceptance::wrong) continue;
    const auto safe = counts.fitted.find({Acceptance::monitor, bin.bits});
    require(safe != counts.fitted.end() && count <= safe->second,
            "'wrong' has more frames than 'monitor'");
  }
}

void read_missed(CampaignCounts& counts, const Json& object, const BlockSet& done,
                 const TrialBlocks& blocks) {
  const Json& missed = list(member(object, "missed"), "missed");
  const auto kept = std::min<std::uint64_t>(missed_kept, counts.total(Acceptance::wrong));
  require(missed.size() == kept, "'missed' has {} frames, 'wrong' asks for {}", missed.size(),
          kept);
  for (const Json& value : missed) {
    const std::uint64_t index = number(value, "missed", blocks.size);
    const bool ascends = counts.missed.empty() || index > counts.missed.back();
    require(ascends && contains(done, blocks.block_of(index)),
            "'missed' has frame {}, out of order or not in 'blocks'", index);
    counts.missed.push_back(index);
  }
}

void read_row(ExperimentRow<CampaignCounts>& row, const FaultChoice& fault, const Json& object) {
  row.done = read_blocks(object, row.blocks);
  row.counts.frames = number(object, "frames");
  std::uint64_t frames = 0;
  for (const auto& run : row.done) {
    frames += std::min(row.blocks.size, row.blocks.first_of(run.upper())) -
              row.blocks.first_of(run.lower());
  }
  require(row.counts.frames == frames, "'frames' is {}, the blocks have {}", row.counts.frames,
          frames);
  const bool flips = fault.kind == FaultKind::flips;
  read_accepted(row.counts, object, flips);
  read_fitted(row.counts, object);
  const bool plain = std::all_of(row.counts.accepted.begin(), row.counts.accepted.end(),
                                 [](const auto& of) { return of == decltype(of){}; });
  require(fault.fitting ? plain : row.counts.fitted.empty(),
          "'accepted' and 'fitted' belong to different faults");
  read_missed(row.counts, object, row.done, row.blocks);
}

CampaignState state_of(const Json& object) {
  require(object.is_object() && object.contains("biss_campaign"),
          "it is not a state of a campaign");
  require(number(object, "biss_campaign") == state_version,
          "its version is {}, this program reads version {}", number(object, "biss_campaign"),
          state_version);
  CampaignPlan plan{.format = text(object, "format"),
                    .rules = text(object, "rules"),
                    .seed = number(object, "seed"),
                    .frames = number(member(object, "frames"), "frames", max_campaign_frames),
                    .faults = {}};
  const Json& faults = list(member(object, "faults"), "faults");
  for (const Json& each : faults) {
    const std::string name = text(each, "fault");
    const auto fault = parse_fault(name);
    require(fault.has_value(), "{} is not a fault", shown(each["fault"]));
    plan.faults.push_back(*fault);
  }
  CampaignState state(std::move(plan));
  for (std::size_t n = 0; n < state.rows.size(); ++n) {
    try {
      read_row(state.rows[n], state.plan.faults[n], faults[n]);
    } catch (const Refused& refused) {
      throw Refused{text_of(state.plan.faults[n]) + ": " + refused.cause};
    }
  }
  return state;
}

}  // namespace

std::uint64_t CampaignPlan::frames_of(const FaultChoice& fault) const {
  return fault.fitting ? std::min(frames, max_fitting_frames) : frames;
}

CampaignState::CampaignState(CampaignPlan asked) : plan(std::move(asked)) {
  for (const FaultChoice& fault : plan.faults) {
    rows.push_back({{plan.frames_of(fault), block_frames}, {}, {}});
  }
}

bool CampaignState::complete() const {
  return std::all_of(rows.begin(), rows.end(), [](const auto& row) { return row.complete(); });
}

std::uint64_t CampaignState::frames_done() const {
  std::uint64_t sum = 0;
  for (const auto& row : rows) sum += row.counts.frames;
  return sum;
}

std::uint64_t CampaignState::frames_planned() const {
  std::uint64_t sum = 0;
  for (const auto& row : rows) sum += row.blocks.size;
  return sum;
}

bool CampaignState::merge(const CampaignState& other) {
  if (plan != other.plan) return false;
  for (std::size_t n = 0; n < rows.size(); ++n) {
    if (intersects(rows[n].done, other.rows[n].done)) return false;
  }
  for (std::size_t n = 0; n < rows.size(); ++n) {
    rows[n].counts.add(other.rows[n].counts);
    rows[n].done += other.rows[n].done;
  }
  return true;
}

bool run_campaign(const CampaignFrame& frame, CampaignState& state, const ExperimentRun& run) {
  return run_experiment(state.rows, run, [&](std::size_t row, std::uint64_t block) {
    return count_block(frame, {state.plan.faults[row], state.plan.seed}, block,
                       state.rows[row].blocks.size_of(block));
  });
}

bool fits(const CampaignFrame& frame, const CampaignState& state) {
  for (const auto& row : state.rows) {
    for (std::size_t what = 0; what < acceptance_count; ++what) {
      const auto& counts = row.counts.accepted[what];
      for (std::size_t weight = bits_of(frame, static_cast<Acceptance>(what)) + 1U;
           weight < weight_count; ++weight) {
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

std::string state_text(const CampaignState& state) {
  Json faults = Json::array();
  for (std::size_t n = 0; n < state.rows.size(); ++n) {
    faults.push_back(json_of(state.plan.faults[n], state.rows[n]));
  }
  const Json text = {{"biss_campaign", state_version}, {"faults", faults},
                     {"format", state.plan.format},    {"frames", state.plan.frames},
                     {"rules", state.plan.rules},      {"seed", state.plan.seed}};
  return text.dump() + "\n";
}

tl::expected<CampaignState, std::string> read_state(std::string_view text) {
  try {
    return state_of(Json::parse(text));
  } catch (const Refused& refused) {
    return tl::unexpected(refused.cause);
  } catch (const Json::exception&) {
    return tl::unexpected(std::string("it is not JSON, or ends early"));
  }
}

}  // namespace biss::lab
