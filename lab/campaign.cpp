#include "lab/campaign.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace biss::lab {
namespace {

struct Work {
  std::size_t fault = 0;
  std::uint64_t block = 0;
};

std::vector<Work> missing(const CampaignState& state, const CampaignShard& shard) {
  std::vector<Work> work;
  const std::uint64_t blocks = state.plan.blocks();
  for (std::size_t fault = 0; fault < state.plan.faults.size(); ++fault) {
    for (std::uint64_t block = shard.number - 1; block < blocks; block += shard.count) {
      if (!state.done[fault][block]) work.push_back({fault, block});
    }
  }
  return work;
}

// Hands out blocks and takes counts; counts are whole numbers, so the order does not matter.
class Crew {
 public:
  Crew(const CampaignFrame& frame, CampaignState& state, const CampaignShard& shard)
      : frame_(frame), state_(state), work_(missing(state, shard)) {}

  void work() {
    while (!stopped_) {
      const std::size_t mine = next_++;
      if (mine >= work_.size()) break;
      const auto [fault, block] = work_[mine];
      const CampaignCounts counts =
          count_block(frame_, {state_.plan.faults[fault], state_.plan.seed}, block,
                      state_.plan.frames_of(block));
      const std::lock_guard lock(mutex_);
      state_.counts[fault].add(counts);
      state_.done[fault][block] = true;
      ++finished_;
      if (finished_ == work_.size()) changed_.notify_all();
    }
  }

  // Returns once all is done, or `save` wants no more.
  bool supervise(const CampaignRun& run) {
    const auto pause = std::chrono::duration<double>(run.save_seconds);
    std::unique_lock lock(mutex_);
    bool more = true;
    const auto all_done = [this] { return finished_ == work_.size(); };
    while (more && !changed_.wait_for(lock, pause, all_done)) {
      if (run.save) more = run.save(state_);
    }
    if (more && run.save) more = run.save(state_);
    stopped_ = true;
    return more;
  }

 private:
  const CampaignFrame& frame_;
  CampaignState& state_;
  std::vector<Work> work_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t finished_ = 0;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> stopped_{false};
};

unsigned bits_of(const CampaignFrame& frame, Acceptance what) {
  if (what == Acceptance::cpw) return frame.cpw_bits();
  if (what == Acceptance::spw) return frame.spw_bits();
  return frame.bits();
}

// How much likelier a pattern with so many wrong bits is than it was drawn.
long double ratio(const FaultChoice& fault, unsigned bits, std::size_t weight) {
  if (fault.drawn_rate == 0) return 1;
  const long double rate = probability_of(fault.rate);
  const long double drawn = probability_of(fault.drawn_rate);
  return std::pow(rate / drawn, static_cast<long double>(weight)) *
         std::pow((1 - rate) / (1 - drawn), static_cast<long double>(bits - weight));
}

constexpr long double two_sided_95 = 1.959963985L;

void set_wilson(CampaignEstimate& estimate, long double frames) {
  const long double z2 = two_sided_95 * two_sided_95;
  const long double p = estimate.rate;
  const long double middle = (p + z2 / (2 * frames)) / (1 + z2 / frames);
  const long double half = two_sided_95 / (1 + z2 / frames) *
                           std::sqrt(p * (1 - p) / frames + z2 / (4 * frames * frames));
  estimate.low = p == 0 ? 0 : std::max(0.0L, middle - half);
  estimate.high = std::min(1.0L, middle + half);
}

constexpr long double enough_events = 100;

}  // namespace

std::uint64_t CampaignPlan::frames_of(std::uint64_t block) const {
  return std::min(block_frames, frames - block * block_frames);
}

CampaignState::CampaignState(CampaignPlan asked)
    : plan(std::move(asked)),
      counts(plan.faults.size()),
      done(plan.faults.size(), std::vector<bool>(plan.blocks())) {}

bool CampaignState::complete() const {
  return std::all_of(done.begin(), done.end(), [](const std::vector<bool>& blocks) {
    return std::find(blocks.begin(), blocks.end(), false) == blocks.end();
  });
}

bool CampaignState::merge(const CampaignState& other) {
  if (plan != other.plan) return false;
  for (std::size_t fault = 0; fault < done.size(); ++fault) {
    for (std::size_t block = 0; block < done[fault].size(); ++block) {
      if (done[fault][block] && other.done[fault][block]) return false;
    }
  }
  for (std::size_t fault = 0; fault < done.size(); ++fault) {
    counts[fault].add(other.counts[fault]);
    for (std::size_t block = 0; block < done[fault].size(); ++block) {
      if (other.done[fault][block]) done[fault][block] = true;
    }
  }
  return true;
}

bool run_campaign(const CampaignFrame& frame, CampaignState& state, const CampaignRun& run) {
  Crew crew(frame, state, run.shard);
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::jthread> threads;
  for (unsigned n = 0; n < (run.threads == 0 ? cores : run.threads); ++n) {
    threads.emplace_back([&crew] { crew.work(); });
  }
  return crew.supervise(run);
}

CampaignEstimate estimate(const CampaignFrame& frame, const FaultChoice& fault,
                          const CampaignCounts& counts, Acceptance what,
                          std::optional<long double> theory) {
  CampaignEstimate found;
  if (counts.frames == 0) return found;
  const auto frames = static_cast<long double>(counts.frames);
  const unsigned bits = bits_of(frame, what);
  long double sum = 0;
  long double squares = 0;
  for (std::size_t weight = 0; weight < weight_count; ++weight) {
    const std::uint64_t events = counts.accepted[static_cast<std::size_t>(what)][weight];
    if (events == 0) continue;
    const long double each = ratio(fault, bits, weight);
    sum += each * static_cast<long double>(events);
    squares += each * each * static_cast<long double>(events);
  }
  found.rate = sum / frames;
  // As many plain events would say as much.
  const long double events = squares > 0 ? sum * sum / squares : 0;
  if (theory) found.expected = *theory * frames;
  long double deviation = 0;
  if (fault.drawn_rate == 0) {
    set_wilson(found, frames);
    if (theory && found.expected >= enough_events) {
      deviation = std::sqrt(*theory * (1 - *theory) / frames);
    }
  } else {
    deviation = std::sqrt(std::max(0.0L, squares / frames - found.rate * found.rate) / frames);
    found.low = std::max(0.0L, found.rate - two_sided_95 * deviation);
    found.high = events == 0 ? 1 : found.rate + two_sided_95 * deviation;
    if (events < enough_events) deviation = 0;
  }
  if (theory && deviation > 0) found.sigma = (found.rate - *theory) / deviation;
  return found;
}

std::optional<FaultChoice> importance_of(const CampaignFrame& frame, const FaultChoice& fault,
                                         std::uint64_t frames, const CampaignTheory& theory) {
  if (fault.kind != CampaignFault::flips || fault.drawn_rate != 0) return std::nullopt;
  const bool rare = std::any_of(theory.begin(), theory.end(), [frames](long double share) {
    return share * static_cast<long double>(frames) < enough_events;
  });
  // Six wrong bits in the safety word are the fewest that its checksum may miss.
  const double drawn = 6.0 / frame.spw_bits();
  if (!rare || 2 * static_cast<double>(probability_of(fault.rate)) > drawn) return std::nullopt;
  FaultChoice weighed = fault;
  weighed.drawn_rate = static_cast<std::uint32_t>(drawn * 4294967296.0);
  return weighed;
}

}  // namespace biss::lab
