#include "lab/campaign.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace biss::lab {
namespace {

// Hands out blocks and takes counts; counts are whole numbers, so the order does not matter.
class Crew {
 public:
  Crew(const CampaignFrame& frame, CampaignState& state, const CampaignShard& shard)
      : frame_(frame), state_(state), shard_(shard), block_(shard.number - 1) {}

  void work() {
    std::unique_lock lock(mutex_);
    while (!stopped_ && find_next()) {
      const std::size_t fault = fault_;
      const std::uint64_t block = block_;
      block_ += shard_.count;
      ++at_work_;
      lock.unlock();
      const CampaignCounts counts =
          count_block(frame_, {state_.plan.faults[fault], state_.plan.seed}, block,
                      state_.plan.frames_of_block(fault, block));
      lock.lock();
      state_.counts[fault].add(counts);
      state_.done[fault][block] = true;
      --at_work_;
    }
    changed_.notify_all();
  }

  // Returns once all is done, or `save` wants no more.
  bool supervise(const CampaignRun& run) {
    const auto pause = std::chrono::duration<double>(run.save_seconds);
    std::unique_lock lock(mutex_);
    bool more = true;
    const auto all_done = [this] { return at_work_ == 0 && !find_next(); };
    while (more && !changed_.wait_for(lock, pause, all_done)) {
      if (run.save) more = run.save(state_);
    }
    if (more && run.save) more = run.save(state_);
    stopped_ = true;
    return more;
  }

 private:
  // Goes to the next block of the shard that is missing; false: there is none.
  bool find_next() {
    for (; fault_ < state_.done.size(); ++fault_, block_ = shard_.number - 1) {
      const std::vector<bool>& done = state_.done[fault_];
      while (block_ < done.size() && done[block_]) block_ += shard_.count;
      if (block_ < done.size()) return true;
    }
    return false;
  }

  const CampaignFrame& frame_;
  CampaignState& state_;
  const CampaignShard shard_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t fault_ = 0;
  std::uint64_t block_;
  unsigned at_work_ = 0;
  bool stopped_ = false;
};

}  // namespace

std::uint64_t CampaignPlan::frames_of(std::size_t fault) const {
  return faults[fault].fitting ? std::min(frames, max_fitting_frames) : frames;
}

std::uint64_t CampaignPlan::blocks_of(std::size_t fault) const {
  return (frames_of(fault) + block_frames - 1) / block_frames;
}

std::uint64_t CampaignPlan::frames_of_block(std::size_t fault, std::uint64_t block) const {
  return std::min(block_frames, frames_of(fault) - block * block_frames);
}

CampaignState::CampaignState(CampaignPlan asked)
    : plan(std::move(asked)), counts(plan.faults.size()) {
  for (std::size_t fault = 0; fault < plan.faults.size(); ++fault) {
    done.emplace_back(plan.blocks_of(fault));
  }
}

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

}  // namespace biss::lab
