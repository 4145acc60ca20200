// A part of a capture: the edges of some request cycles and of their neighbours.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// A cycle of an excerpt, and its row in the whole capture.
struct ExcerptCycle {
  std::uint64_t number = 0;
  Picoseconds time;
  /// A line of `biss decode --to csv`.
  std::string row;
  bool failed = false;
  /// It was chosen; others are there as neighbours.
  bool chosen = false;
};

/// Sees the edges of a capture as they are read, and keeps the edges of each chosen cycle, of the
/// cycle before it and of the cycle after it. Between them the lines are unknown.
class Excerpt final : public flow::ChangeWatcher {
 public:
  explicit Excerpt(const decode::Lines& lines) : lines_(lines) {}

  void take(std::span<const wire::Edge> edges) override;
  void take(const capture::PairPiece& changes) override;
  /// The next cycle of the capture.
  void add(ExcerptCycle cycle);
  /// After the last cycle.
  void finish(Picoseconds end);

  /// The cycles with their edges, in their order.
  const std::vector<ExcerptCycle>& cycles() const { return cycles_; }
  /// The first `count` cycles as a VCD of the lines MA and SLO.
  std::string vcd(std::size_t count) const;
  /// Cycles of the excerpt that are missing: they had too many edges, or began before 0.
  std::uint64_t lost() const { return lost_; }

 private:
  static constexpr std::int64_t before_all = std::numeric_limits<std::int64_t>::min();

  struct Pending {
    ExcerptCycle cycle;
    std::int64_t from = before_all;
    bool wanted = false;
  };

  std::int64_t needed_from() const { return pending_ ? pending_->from : before_all; }
  void settle();
  void fetch(const capture::PairPiece& changes, std::int64_t from, std::int64_t to,
             std::array<std::size_t, 2>& at);
  void queue(std::int64_t to);
  void copy(Pending& window, std::int64_t to);
  void leave(std::int64_t time);

  decode::Lines lines_;
  std::optional<Pending> pending_;
  bool chosen_before_ = false;
  std::vector<std::pair<Pending, std::int64_t>> queue_;
  // Edges of line 0, MA, and line 1, SLO, that are not copied yet, and the levels before them.
  std::vector<wire::Edge> held_;
  // The number of first edges of held_ that are no longer needed.
  std::ptrdiff_t left_ = 0;
  std::array<wire::Level, 2> levels_{wire::Level::unknown, wire::Level::unknown};
  std::int64_t dropped_to_ = before_all;
  std::int64_t last_to_ = before_all;
  std::vector<wire::Edge> edges_;
  std::vector<ExcerptCycle> cycles_;
  // For each cycle the index and the time at which its edges end.
  std::vector<std::pair<std::size_t, std::int64_t>> ends_;
  std::int64_t end_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace biss::verbs
