// A line's levels over a stretch of time, for look-ups of the level at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "biss/base/units.hpp"
#include "wire/edge.hpp"

namespace biss::decode {

/// One change of one line.
struct LevelChange {
  Picoseconds time;
  wire::Level level = wire::Level::unknown;
};

/// The level of a line that may be inverted.
constexpr wire::Level seen_as(wire::Level level, bool inverted) {
  if (!inverted || level == wire::Level::unknown) return level;
  return level == wire::Level::low ? wire::Level::high : wire::Level::low;
}

/// The changes of a line that cycles still to be read may need. Bounded: beyond `max_changes` the
/// level is unknown until something is forgotten, unless push_recent() drops the oldest ones.
class LineHistory {
 public:
  static constexpr std::size_t max_changes = std::size_t{1} << 16U;

  void push(LevelChange change) {
    if (changes_.size() < max_changes) {
      changes_.push_back(change);
    } else {
      changes_.back().level = wire::Level::unknown;
    }
  }

  /// The same if it changes the level. If there are `most` changes, the older half is dropped.
  void push_recent(LevelChange change, std::size_t most) {
    if (level_before(size()) == change.level) return;
    if (size() >= most) forget(most / 2);
    changes_.push_back(change);
  }

  /// Index of the first change after `time`.
  std::size_t after(Picoseconds time) const {
    const auto it =
        std::upper_bound(changes_.begin(), changes_.end(), time,
                         [](Picoseconds t, const LevelChange& change) { return t < change.time; });
    return static_cast<std::size_t>(it - changes_.begin());
  }

  /// Index of the first change at `time` or after it.
  std::size_t from(Picoseconds time) const {
    const auto it =
        std::lower_bound(changes_.begin(), changes_.end(), time,
                         [](const LevelChange& change, Picoseconds t) { return change.time < t; });
    return static_cast<std::size_t>(it - changes_.begin());
  }

  wire::Level level_at(Picoseconds time) const { return level_before(after(time)); }
  /// The level that change `index` ends; `index` may be size().
  wire::Level level_before(std::size_t index) const {
    return index == 0 ? before_ : changes_[index - 1].level;
  }

  /// The time at which the line took that level; empty if that was before the first known level.
  std::optional<Picoseconds> taken_at(std::size_t index) const {
    if (index == 0) return before_since_;
    const bool known = level_before(index - 1) != wire::Level::unknown;
    return known ? std::optional(changes_[index - 1].time) : std::nullopt;
  }

  /// The changes in [begin, end). Valid until the next push.
  std::span<const LevelChange> between(Picoseconds begin, Picoseconds end) const {
    const std::size_t first = from(begin);
    return std::span(changes_).subspan(first, std::max(first, from(end)) - first);
  }

  std::size_t size() const { return changes_.size(); }
  const LevelChange& operator[](std::size_t index) const { return changes_[index]; }

  /// Forgets the first `gone` changes, and keeps the level after them.
  void forget(std::size_t gone) {
    before_since_ = taken_at(gone);
    before_ = level_before(gone);
    changes_.erase(changes_.begin(), changes_.begin() + static_cast<std::ptrdiff_t>(gone));
  }

  void forget_before(Picoseconds time) { forget(after(time)); }

  /// Forgets everything but this level, taken at this time.
  void restart(wire::Level level, Picoseconds since) {
    changes_.clear();
    before_ = level;
    before_since_ = since;
  }

 private:
  std::vector<LevelChange> changes_;
  wire::Level before_ = wire::Level::unknown;
  std::optional<Picoseconds> before_since_;
};

}  // namespace biss::decode
