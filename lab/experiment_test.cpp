#include "lab/experiment.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <new>
#include <vector>

namespace biss::lab {
namespace experiment_test {

struct Sum {
  std::uint64_t trials = 0;
  void add(const Sum& other) { trials += other.trials; }
};

std::vector<ExperimentRow<Sum>> two_rows() { return {{{1000, 10}, {}, {}}, {{55, 10}, {}, {}}}; }

bool run_on(std::vector<ExperimentRow<Sum>>& rows, const ExperimentRun& run) {
  return run_experiment(rows, run, [&rows](std::size_t row, std::uint64_t block) {
    return Sum{rows[row].blocks.size_of(block)};
  });
}

TEST(Parallel, EveryPiece_IsDoneOnce) {
  std::vector<std::atomic<int>> done(1000);
  parallel_for(3, done.size(), [&done](std::size_t n) { ++done[n]; });
  for (const auto& times : done) EXPECT_EQ(times, 1);
}

TEST(Parallel, ExceptionOfAnyThread_ArrivesAtTheCaller) {
  for (const std::size_t thrower : {0U, 500U, 999U}) {
    EXPECT_THROW(parallel_for(3, 1000,
                              [thrower](std::size_t n) {
                                if (n == thrower) throw std::bad_alloc();
                              }),
                 std::bad_alloc);
  }
}

TEST(Experiment, EveryTrial_IsCountedOnce) {
  auto rows = two_rows();
  EXPECT_TRUE(run_on(rows, {.threads = 3}));
  EXPECT_EQ(rows[0].counts.trials, 1000U);
  EXPECT_EQ(rows[1].counts.trials, 55U);
  EXPECT_TRUE(rows[1].complete());
}

TEST(Experiment, Shards_AddUpToTheWhole) {
  auto rows = two_rows();
  for (const std::uint64_t number : {2U, 1U, 3U}) {
    EXPECT_FALSE(rows[0].complete());
    EXPECT_TRUE(run_on(rows, {.threads = 2, .shard = {number, 3}}));
  }
  EXPECT_TRUE(rows[0].complete());
  EXPECT_EQ(rows[0].counts.trials, 1000U);
  EXPECT_EQ(rows[1].counts.trials, 55U);
}

TEST(Experiment, Interruption_EndsItAfterALastSave) {
  auto rows = two_rows();
  unsigned saves = 0;
  ExperimentRun run{.threads = 1, .save_seconds = 1e9};
  run.save = [&] { return ++saves > 0; };
  run.interrupted = [&] { return rows[0].done.size() == 7; };
  EXPECT_FALSE(run_on(rows, run));
  EXPECT_EQ(rows[0].counts.trials, 70U);
  EXPECT_EQ(saves, 1U);
  run.interrupted = {};
  EXPECT_TRUE(run_on(rows, run));
  EXPECT_EQ(rows[0].counts.trials, 1000U);
}

TEST(Experiment, SaveThatFails_EndsIt) {
  auto rows = two_rows();
  ExperimentRun run{.threads = 2, .save_seconds = 0};
  unsigned saves = 0;
  run.save = [&] { return ++saves < 3; };
  EXPECT_FALSE(run_on(rows, run));
  EXPECT_EQ(saves, 3U);
  EXPECT_FALSE(rows[0].complete());
}

}  // namespace experiment_test
}  // namespace biss::lab
