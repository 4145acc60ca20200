// The measuring loop. The measured function is inlined into it, as in a program that decodes in one
// place.
#pragma once

#include <benchmark/benchmark.h>

#include <bit>
#include <cstddef>
#include <cstdint>

namespace biss::bench {

/// Calls `work(i)` for i = 0…count - 1, again and again. The results are hashed, so that none can
/// be left out and no call waits for another.
template <class Work>
[[gnu::flatten]] void measure(benchmark::State& state, std::size_t count, Work work) {
  for ([[maybe_unused]] auto _ : state) {
    std::uint64_t hash = 0;
    for (std::size_t i = 0; i < count; ++i) hash = std::rotl(hash, 1) ^ work(i);
    benchmark::DoNotOptimize(hash);
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

/// The same, but each call waits for the result of the previous one: `work(i, answer)`.
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
