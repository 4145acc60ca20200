// The engine of campaigns and sequences: rows of trials, counted in numbered blocks on all cores. A
// block depends on nothing but its row and its number, and counts are whole numbers. So the result
// is the same for any number of threads, after any interruption, and in any number of shards.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace biss::lab {

/// The seed of a row's random numbers. It depends on the row's name and not on other rows.
std::uint64_t row_seed(std::uint64_t seed, std::string_view name);

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

/// A set of block numbers. Its memory grows with the gaps between them, not with their values.
class BlockSet {
 public:
  /// Consecutive numbers: first…end - 1.
  struct Run {
    std::uint64_t first = 0;
    std::uint64_t end = 0;
    bool operator==(const Run&) const = default;
  };

  bool operator==(const BlockSet&) const = default;
  bool contains(std::uint64_t block) const;
  /// \pre the set does not contain it
  void add(std::uint64_t block);
  /// Adds a run after all others. Returns false, and changes nothing, if the run is empty or does
  /// not begin after the last block of the set.
  [[nodiscard]] bool append(Run run);
  bool intersects(const BlockSet& other) const;
  /// \pre the sets do not intersect
  void add(const BlockSet& other);
  /// In ascending order, with a gap between two runs.
  const std::vector<Run>& runs() const { return runs_; }
  /// The number of blocks.
  std::uint64_t size() const;

 private:
  std::vector<Run> runs_;
};

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

inline constexpr std::uint64_t max_shards = std::uint64_t{1} << 20U;

/// Every count-th block, from block number - 1 on. \pre 1 <= number <= count <= max_shards
struct Shard {
  std::uint64_t number = 1;
  std::uint64_t count = 1;
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

struct BlockRow {
  TrialBlocks blocks{};
  BlockSet* done = nullptr;
};

/// \param count counts block `block` of row `row`, in any thread; returns the function that adds
///   the counts to the row, one call at a time
bool run_blocks(
    const std::vector<BlockRow>& rows, const ExperimentRun& run,
    const std::function<std::function<void()>(std::size_t row, std::uint64_t block)>& count);

/// Counts the missing blocks of the shard.
/// \param trial trial(row, block) returns the counts of a block
/// \return false if `save` or `interrupted` ended the run
template <class Counts, class Trial>
bool run_experiment(std::vector<ExperimentRow<Counts>>& rows, const ExperimentRun& run,
                    const Trial& trial) {
  std::vector<BlockRow> blocks;
  for (ExperimentRow<Counts>& row : rows) blocks.push_back({row.blocks, &row.done});
  return run_blocks(blocks, run, [&](std::size_t row, std::uint64_t block) {
    return [&sum = rows[row].counts, counts = trial(row, block)] { sum.add(counts); };
  });
}

}  // namespace biss::lab
