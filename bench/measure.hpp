// The loop around what is measured. All of it is inlined there, as it is where a program has one
// place that decodes.
#pragma once

#include <benchmark/benchmark.h>

#include <bit>
#include <cstddef>
#include <cstdint>

namespace biss::bench {

/// `work(i)` for i = 0…count - 1, again and again; the answers are hashed, so that none can be left
/// out and none waits for another.
template <class Work>
[[gnu::flatten]] void measure(benchmark::State& state, std::size_t count, Work work) {
  for ([[maybe_unused]] auto _ : state) {
    std::uint64_t hash = 0;
    for (std::size_t i = 0; i < count; ++i) hash = std::rotl(hash, 1) ^ work(i);
    benchmark::DoNotOptimize(hash);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

/// The same, each call waiting for the answer of the one before: `work(i, answer)`.
template <class Work>
[[gnu::flatten]] void measure_chain(benchmark::State& state, std::size_t count, Work work) {
  for ([[maybe_unused]] auto _ : state) {
    std::uint64_t answer = 0;
    for (std::size_t i = 0; i < count; ++i) answer = work(i, answer);
    benchmark::DoNotOptimize(answer);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

}  // namespace biss::bench
