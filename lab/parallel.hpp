// Work on several threads.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>

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

}  // namespace biss::lab
