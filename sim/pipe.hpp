// A cable: edges on their way.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/timing/step.hpp"
#include "sim/random.hpp"

namespace biss::sim {

/// Edges of a level in flight, first in, first out; each inverts the level. The memory grows to the
/// largest number in flight.
class Pipe {
 public:
  /// The arrival of the next edge; `never` without one in flight.
  Picoseconds front() const { return front_; }

  /// Adds an edge that arrives at `arrival`, or a picosecond after the previous one: edges do not
  /// overtake each other.
  void push(Picoseconds arrival) {
    if (first_ == end_) {
      front_ = arrival;
    } else {
      arrival.count = std::max(arrival.count, times_[(end_ - 1U) & mask_].count + 1);
      if (end_ - first_ > mask_) grow();
    }
    times_[end_++ & mask_] = arrival;
  }

  /// Adds an edge that is sent now: it arrives after the delay, give or take the jitter.
  void send(Picoseconds now, Picoseconds delay, Picoseconds jitter, Random& random) {
    Picoseconds arrival = now + delay;
    if (jitter.count != 0) {
      const auto width = static_cast<std::uint64_t>(2 * jitter.count + 1);
      arrival += picoseconds(static_cast<std::int64_t>(random.below(width))) - jitter;
    }
    push(arrival);
  }
  /// \pre front() is not `never`
  void pop() {
    ++first_;
    front_ = first_ == end_ ? never : times_[first_ & mask_];
  }

 private:
  void grow() {
    std::vector<Picoseconds> wider(2 * times_.size());
    const std::size_t wide = wider.size() - 1U;
    for (std::size_t i = first_; i != end_; ++i) wider[i & wide] = times_[i & mask_];
    times_.swap(wider);
    mask_ = wide;
  }

  std::vector<Picoseconds> times_ = std::vector<Picoseconds>(64);
  std::size_t mask_ = 63;
  std::size_t first_ = 0;
  std::size_t end_ = 0;
  Picoseconds front_ = never;
};

}  // namespace biss::sim
