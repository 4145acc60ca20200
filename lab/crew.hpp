// Work on all cores: numbered pieces, handed out one by one.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <thread>
#include <vector>

namespace biss::lab {

/// Calls work(n) once for every n below `count`, in any order, several at a time, and returns when
/// all are done.
/// \param threads 0: as many as there are cores
/// \pre work does not throw
template <class Work>
void share_out(unsigned threads, std::size_t count, const Work& work) {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  std::atomic<std::size_t> next{0};
  std::vector<std::jthread> crew;
  for (unsigned n = 0; n < (threads == 0 ? cores : threads); ++n) {
    crew.emplace_back([&] {
      for (std::size_t mine = next++; mine < count; mine = next++) work(mine);
    });
  }
}

}  // namespace biss::lab
