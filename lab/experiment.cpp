#include "lab/experiment.hpp"

#include <algorithm>
#include <chrono>
#include <exception>
#include <future>
#include <iterator>
#include <mutex>
#include <optional>
#include <thread>

#include "lab/parallel.hpp"
#include "sim/random.hpp"

namespace biss::lab {
namespace {

struct Place {
  std::size_t row = 0;
  std::uint64_t block = 0;
};

// The blocks of a shard that are missing at the start, row after row.
class MissingBlocks {
 public:
  MissingBlocks(const std::vector<BlockRow>& rows, const Shard& shard)
      : rows_(rows), shard_(shard), next_{0, shard.number - 1} {}

  std::optional<Place> take() {
    for (; next_.row < rows_.size(); next_ = {next_.row + 1, shard_.number - 1}) {
      const BlockRow& row = rows_[next_.row];
      while (next_.block < row.blocks.count() && row.done->contains(next_.block)) {
        next_.block += shard_.count;
      }
      if (next_.block >= row.blocks.count()) continue;
      const Place place = next_;
      next_.block += shard_.count;
      return place;
    }
    return std::nullopt;
  }

 private:
  const std::vector<BlockRow>& rows_;
  Shard shard_;
  Place next_;
};

}  // namespace

void run_workers(unsigned threads, const std::function<bool()>& step) {
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  std::atomic<bool> failed{false};
  const auto work = [&] {
    try {
      while (!failed && step()) {
      }
    } catch (...) {
      failed = true;
      throw;
    }
  };
  std::vector<std::future<void>> others;
  for (unsigned n = 1; n < threads; ++n) {
    try {
      others.push_back(std::async(std::launch::async, work));
    } catch (const std::exception&) {
      break;
    }
  }
  work();
  for (std::future<void>& other : others) other.get();
}

// FNV-1a.
std::uint64_t row_seed(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char letter : name) {
    hash = (hash ^ static_cast<std::uint8_t>(letter)) * 0x100000001B3U;
  }
  return sim::scrambled(seed) ^ hash;
}

bool BlockSet::contains(std::uint64_t block) const {
  const auto after =
      std::upper_bound(runs_.begin(), runs_.end(), block,
                       [](std::uint64_t number, const Run& run) { return number < run.first; });
  return after != runs_.begin() && block < std::prev(after)->end;
}

void BlockSet::add(std::uint64_t block) {
  const auto after =
      std::upper_bound(runs_.begin(), runs_.end(), block,
                       [](std::uint64_t number, const Run& run) { return number < run.first; });
  const bool extends = after != runs_.begin() && std::prev(after)->end == block;
  const bool precedes = after != runs_.end() && after->first == block + 1;
  if (extends && precedes) {
    std::prev(after)->end = after->end;
    runs_.erase(after);
  } else if (extends) {
    ++std::prev(after)->end;
  } else if (precedes) {
    --after->first;
  } else {
    runs_.insert(after, {block, block + 1});
  }
}

bool BlockSet::append(Run run) {
  if (run.first >= run.end || (!runs_.empty() && run.first < runs_.back().end)) return false;
  if (!runs_.empty() && run.first == runs_.back().end) {
    runs_.back().end = run.end;
  } else {
    runs_.push_back(run);
  }
  return true;
}

bool BlockSet::intersects(const BlockSet& other) const {
  auto a = runs_.begin();
  auto b = other.runs_.begin();
  while (a != runs_.end() && b != other.runs_.end()) {
    if (a->first < b->end && b->first < a->end) return true;
    (a->end <= b->first ? a : b)++;
  }
  return false;
}

void BlockSet::add(const BlockSet& other) {
  std::vector<Run> all;
  std::merge(runs_.begin(), runs_.end(), other.runs_.begin(), other.runs_.end(),
             std::back_inserter(all),
             [](const Run& one, const Run& two) { return one.first < two.first; });
  runs_.clear();
  for (const Run& run : all) static_cast<void>(append(run));
}

std::uint64_t BlockSet::size() const {
  std::uint64_t sum = 0;
  for (const Run& run : runs_) sum += run.end - run.first;
  return sum;
}

bool run_blocks(
    const std::vector<BlockRow>& rows, const ExperimentRun& run,
    const std::function<std::function<void()>(std::size_t row, std::uint64_t block)>& count) {
  using Clock = std::chrono::steady_clock;
  const std::chrono::duration<double> pause(run.save_seconds);
  MissingBlocks missing(rows, run.shard);
  std::mutex mutex;
  bool stopped = false;
  bool saved = false;
  bool failed = false;
  Clock::time_point last = Clock::now();
  const auto save = [&] {
    saved = true;
    last = Clock::now();
    failed = run.save && !run.save();
    stopped = stopped || failed;
  };
  run_workers(run.threads, [&] {
    std::unique_lock lock(mutex);
    if (stopped) return false;
    const auto place = missing.take();
    if (!place) return false;
    lock.unlock();
    const std::function<void()> add = count(place->row, place->block);
    lock.lock();
    add();
    rows[place->row].done->add(place->block);
    saved = false;
    if (run.interrupted && run.interrupted()) stopped = true;
    if (!stopped && Clock::now() - last >= pause) save();
    return !stopped;
  });
  if (!saved && !failed) save();
  return !stopped;
}

}  // namespace biss::lab
