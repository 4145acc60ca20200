// A cable: edges on their way.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>

#include "biss/base/units.hpp"
#include "biss/timing/step.hpp"
#include "sim/random.hpp"

namespace biss::sim {

/// Edges of a level in flight, first in, first out; each inverts the level.
class Pipe {
 public:
  /// The arrival of the next edge; `never` without one in flight.
  Picoseconds front() const { return times_.empty() ? never : times_.front(); }

  /// Adds an edge that is sent now: it arrives after the delay, give or take the jitter, or a
  /// picosecond after the previous one: edges do not overtake each other.
  void send(Picoseconds now, Picoseconds delay, Picoseconds jitter, Random& random) {
    Picoseconds arrival = now + delay;
    if (jitter.count != 0) {
      const auto width = static_cast<std::uint64_t>(2 * jitter.count + 1);
      arrival += picoseconds(static_cast<std::int64_t>(random.below(width))) - jitter;
    }
    if (!times_.empty()) arrival = std::max(arrival, times_.back() + picoseconds(1));
    times_.push_back(arrival);
  }
  /// \pre front() is not `never`
  void pop() { times_.pop_front(); }

 private:
  std::deque<Picoseconds> times_;
};

}  // namespace biss::sim
