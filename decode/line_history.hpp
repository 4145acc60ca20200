// A line's levels over a stretch of time, to be asked "what was it at t?".
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "biss/base/units.hpp"
#include "wire/edge.hpp"

namespace biss::decode {

/// One change of one line.
struct LevelChange {
  Picoseconds time;
  wire::Level level = wire::Level::unknown;
};

/// The changes of SLO that cycles still to be read may need. Bounded: when more than `max_changes`
/// come within one cycle, the later ones are not kept and the level from there on is unknown.
class LineHistory {
 public:
  static constexpr std::size_t max_changes = std::size_t{1} << 16U;

  void push(LevelChange change) {
    if (changes_.size() < max_changes) {
      changes_.push_back(change);
    } else {
      changes_.back() = {changes_.back().time, wire::Level::unknown};
      latest_ = change;
    }
  }

  /// Index of the first change after `time`.
  std::size_t after(Picoseconds time) const {
    const auto it =
        std::upper_bound(changes_.begin(), changes_.end(), time,
                         [](Picoseconds t, const LevelChange& change) { return t < change.time; });
    return static_cast<std::size_t>(it - changes_.begin());
  }

  wire::Level level_at(Picoseconds time) const {
    const std::size_t next = after(time);
    return next == 0 ? before_ : changes_[next - 1].level;
  }

  std::size_t size() const { return changes_.size(); }
  const LevelChange& operator[](std::size_t index) const { return changes_[index]; }

  /// Forgets what lies before `time`, keeping the level it left.
  void forget_before(Picoseconds time) {
    const std::size_t gone = after(time);
    if (gone != 0) before_ = changes_[gone - 1].level;
    changes_.erase(changes_.begin(), changes_.begin() + static_cast<std::ptrdiff_t>(gone));
    if (latest_ && changes_.size() < max_changes) {
      changes_.push_back(*latest_);
      latest_.reset();
    }
  }

 private:
  std::vector<LevelChange> changes_;
  std::optional<LevelChange> latest_;
  wire::Level before_ = wire::Level::unknown;
};

}  // namespace biss::decode
