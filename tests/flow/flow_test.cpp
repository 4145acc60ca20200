#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/flow/flow_trial.hpp"

namespace biss::flow_trial {
namespace flow_test {

#ifdef BISS_LONG
constexpr std::uint64_t trials = 500;
#else
constexpr std::uint64_t trials = 40;
#endif

void expect_same(const std::vector<std::string>& rows, const std::vector<std::string>& expected) {
  ASSERT_EQ(rows.size(), expected.size());
  for (std::size_t i = 0; i < rows.size(); ++i) ASSERT_EQ(rows[i], expected[i]) << "row " << i;
}

// Threads and sizes are drawn: all combinations of all captures are too many.
void compare(const Trial& trial, const Container& container, std::uint64_t number) {
  SCOPED_TRACE(fmt::format("trial {}, {}", number, container.name));
  const auto expected = by_edges(trial, container);
  ASSERT_FALSE(expected.empty());
  constexpr std::array<unsigned, 4> threads{1, 2, 3, 7};
  constexpr std::array<std::size_t, 6> sizes{64, 1'000, 4'096, 65'536, 1U << 20U, 64U << 20U};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::size_t draw = number * 2 + i;
    const unsigned count = threads[draw % threads.size()];
    const std::size_t size = sizes[draw % sizes.size()];
    SCOPED_TRACE(fmt::format("{} threads, pieces of {} bytes", count, size));
    expect_same(by_flow(trial, container, count, size), expected);
  }
}

TEST(Flow, EveryFaultInEveryContainer_SameCyclesAsEdgeByEdge) {
  for (std::uint64_t number = 0; number < trials; ++number) {
    const Trial trial(number);
    for (const Container& container : change_containers(trial)) {
      compare(trial, container, number);
      if (HasFatalFailure()) return;
    }
    std::vector<std::string> first;
    for (const Container& container : sampled_containers(trial)) {
      compare(trial, container, number);
      if (HasFatalFailure()) return;
      // Sampled alike, they show the same.
      const auto rows = by_flow(trial, container, 2, 4'096);
      if (first.empty()) first = rows;
      expect_same(rows, first);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace flow_test
}  // namespace biss::flow_trial
