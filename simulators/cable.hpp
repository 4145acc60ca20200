// One direction of a cable in a simulation: changes of level that are on their way.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

#include "capi/biss_c.h"

namespace biss::simulators {

class Cable {
 public:
  /// More changes are not kept: the line would carry pulses of picoseconds.
  static constexpr std::size_t capacity = 65'536;

  /// A level at this end, which arrives `delay` later, but not before earlier changes. False: the
  /// cable is full and loses the change.
  bool put(std::int64_t now, bool level, std::int64_t delay) {
    if (level == sent_) return true;
    if (changes_.size() == capacity) return false;
    sent_ = level;
    last_ = std::max(last_, now + delay);
    changes_.emplace_back(last_, level);
    return true;
  }

  /// When the next change arrives, or BISS_NEVER.
  std::int64_t due() const { return changes_.empty() ? BISS_NEVER : changes_.front().first; }

  /// Takes all changes that have arrived. \return whether the level has changed
  bool take(std::int64_t now) {
    const bool before = received_;
    for (; due() <= now; changes_.pop_front()) received_ = changes_.front().second;
    return received_ != before;
  }

  bool received() const { return received_; }

 private:
  std::deque<std::pair<std::int64_t, bool>> changes_;
  std::int64_t last_ = -BISS_TIME_MAX;
  bool sent_ = true;
  bool received_ = true;
};

}  // namespace biss::simulators
