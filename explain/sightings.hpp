// The number of times that something was seen, and the cycles.
#pragma once

#include <algorithm>
#include <cstdint>

#include "biss/base/units.hpp"

namespace biss::explain {

struct Sightings {
  std::uint64_t count = 0;
  std::uint64_t first_cycle = 0;
  std::uint64_t last_cycle = 0;
  Picoseconds first_time{};

  void add(std::uint64_t cycle, Picoseconds time) { add({1, cycle, cycle, time}); }
  void add(const Sightings& other) {
    if (other.count == 0) return;
    if (count == 0 || other.first_cycle < first_cycle) {
      first_cycle = other.first_cycle;
      first_time = other.first_time;
    }
    last_cycle = count == 0 ? other.last_cycle : std::max(last_cycle, other.last_cycle);
    count += other.count;
  }
};

}  // namespace biss::explain
