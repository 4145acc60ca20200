// The engine of campaigns and sequences: rows of trials, counted in numbered blocks on all cores. A
// block depends on nothing but its row and its number, and counts are whole numbers. So the result
// is the same for any number of threads, after any interruption, and in any number of shards.
#pragma once

#include <atomic>
#include <boost/icl/interval_set.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string_view>
#include <vector>

#include "lab/shard.hpp"

namespace biss::lab {

/// Runs threads that call step() until it returns false, and returns when all have ended. An
/// exception of step() ends the other threads after their current step and is rethrown here. If a
/// thread cannot be started, those that run do its work.
/// \param threads 0: one for each core
void run_workers(unsigned threads, const std::function<bool()>& step);

/// Calls work(n) once for every n below `count`, in any order, several at a time.
template <class Work>
void parallel_for(unsigned threads, std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{0};
  run_workers(threads, [&] {
    const std::size_t n = next++;
    if (n < count) work(n);
    return n < count;
  });
}

/// The seed of a row's random numbers. It depends on the row's name and not on other rows.
std::uint64_t row_seed(std::uint64_t seed, std::string_view name);

/// The name that the random numbers of a fault or a variant depend on: its former name, if it was
/// renamed, so that its counts stay the same.
std::string_view seed_name(std::string_view name);

/// Trials 0…size - 1 of a row, divided into blocks; only the last block may have fewer trials.
struct TrialBlocks {
  std::uint64_t size = 0;
  std::uint64_t block_size = 1;

  bool operator==(const TrialBlocks&) const = default;
  constexpr std::uint64_t count() const {
    return size / block_size + (size % block_size != 0 ? 1 : 0);
  }
  constexpr std::uint64_t first_of(std::uint64_t block) const { return block * block_size; }
  /// Trials of a block. \pre block is below count()
  constexpr std::uint64_t size_of(std::uint64_t block) const {
    const std::uint64_t rest = size - first_of(block);
    return rest < block_size ? rest : block_size;
  }
  constexpr std::uint64_t block_of(std::uint64_t trial) const { return trial / block_size; }
};

/// A set of block numbers, kept as intervals.
using BlockSet = boost::icl::interval_set<std::uint64_t, std::less,
                                          boost::icl::right_open_interval<std::uint64_t>>;

/// Adds an index to an ascending list that keeps the lowest `most` indices, each once.
void keep_lowest(std::vector<std::uint64_t>& list, std::uint64_t index, std::size_t most);

/// Counts has add(const Counts&).
template <class Counts>
struct ExperimentRow {
  TrialBlocks blocks;
  /// The blocks that are in the counts.
  BlockSet done;
  Counts counts;

  bool operator==(const ExperimentRow&) const = default;
  bool complete() const { return done.size() == blocks.count(); }
};

struct ExperimentRun {
  /// 0: one for each core.
  unsigned threads = 0;
  Shard shard{};
  /// Called every `save_seconds` and at the end, while the rows do not change. False ends the run.
  std::function<bool()> save{};
  double save_seconds = 5;
  /// Called after each block. True ends the run, after a last save.
  std::function<bool()> interrupted{};
};

/// Counts the missing blocks of the shard, row after row.
/// \param trial trial(row, block) returns the counts of a block, in any thread
/// \return false if `save` or `interrupted` ended the run
template <class Counts, class Trial>
bool run_experiment(std::vector<ExperimentRow<Counts>>& rows, const ExperimentRun& run,
                    const Trial& trial) {
  using Clock = std::chrono::steady_clock;
  std::mutex mutex;
  std::size_t row = 0;
  std::uint64_t next = run.shard.number - 1;
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
    while (row < rows.size() &&
           (next >= rows[row].blocks.count() || contains(rows[row].done, next))) {
      const bool ends = next >= rows[row].blocks.count();
      if (ends) ++row;
      next = ends ? run.shard.number - 1 : next + run.shard.count;
    }
    if (stopped || row == rows.size()) return false;
    ExperimentRow<Counts>& current = rows[row];
    const std::uint64_t block = next;
    const std::size_t number = row;
    next += run.shard.count;
    lock.unlock();
    const Counts counts = trial(number, block);
    lock.lock();
    current.counts.add(counts);
    current.done.add(block);
    saved = false;
    if (run.interrupted && run.interrupted()) stopped = true;
    const std::chrono::duration<double> elapsed = Clock::now() - last;
    if (!stopped && elapsed.count() >= run.save_seconds) save();
    return !stopped;
  });
  if (!saved && !failed) save();
  return !stopped;
}

}  // namespace biss::lab
