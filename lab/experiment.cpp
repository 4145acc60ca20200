#include "lab/experiment.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <future>
#include <thread>

#include "sim/random.hpp"

namespace biss::lab {

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

std::string_view seed_name(std::string_view name) {
  constexpr std::array<std::array<std::string_view, 2>, 7> renamed{{{"lost_bit", "lost_clock"},
                                                                    {"doubled_bit", "double_clock"},
                                                                    {"lost_start", "late_start"},
                                                                    {"false_start", "early_start"},
                                                                    {"skipped", "passed_over"},
                                                                    {"not_called", "unheard"},
                                                                    {"permanent", "for_good"}}};
  for (const auto& [now, former] : renamed) {
    if (name == now) return former;
  }
  return name;
}

// FNV-1a.
std::uint64_t row_seed(std::uint64_t seed, std::string_view name) {
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char letter : name) {
    hash = (hash ^ static_cast<std::uint8_t>(letter)) * 0x100000001B3U;
  }
  return sim::scrambled(seed) ^ hash;
}

void keep_lowest(std::vector<std::uint64_t>& list, std::uint64_t index, std::size_t most) {
  const auto place = std::lower_bound(list.begin(), list.end(), index);
  if (place != list.end() && *place == index) return;
  list.insert(place, index);
  if (list.size() > most) list.pop_back();
}

}  // namespace biss::lab
