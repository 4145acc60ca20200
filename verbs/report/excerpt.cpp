#include "verbs/report/excerpt.hpp"

#include <algorithm>

#include "capture/bytes.hpp"
#include "capture/vcd.hpp"

namespace biss::verbs {

namespace {

using wire::Edge;
using wire::Level;

// The idle line before a request is shown for this time at most.
constexpr std::int64_t lead_max = 1'000'000;
// Edges that wait for the end of their cycle, and edges of an excerpt.
constexpr std::size_t held_max = std::size_t{1} << 22U;
constexpr std::size_t edges_max = std::size_t{1} << 22U;

bool is_earlier(const Edge& a, const Edge& b) { return a.time < b.time; }

}  // namespace

// The cycles before these edges have been added.
void Excerpt::take(std::span<const Edge> edges) {
  settle();
  for (const Edge& edge : edges) {
    if (edge.line == lines_.ma) held_.push_back({edge.time, 0, edge.level});
    if (edge.line == lines_.slo) held_.push_back({edge.time, 1, edge.level});
  }
}

// Takes changes of which only few are needed.
void Excerpt::take(const capture::PairPiece& changes) {
  std::array<std::size_t, 2> at{};
  for (auto& [window, to] : queue_) {
    fetch(changes, window.from, to, at);
    copy(window, to);
  }
  queue_.clear();
  fetch(changes, needed_from(), std::numeric_limits<std::int64_t>::max(), at);
  settle();
}

// Appends the changes between two times; `at` is the first change of each line that has not been
// visited.
void Excerpt::fetch(const capture::PairPiece& changes, std::int64_t from, std::int64_t to,
                    std::array<std::size_t, 2>& at) {
  leave(from);
  const auto append = [&](wire::LineIndex index, const capture::LineChanges& line) {
    const auto level = [&](std::size_t place) {
      return line.first_high == (place % 2 == 0) ? Level::high : Level::low;
    };
    const auto place_of = [&](std::int64_t time) {
      const auto begin = line.times.begin() + static_cast<std::ptrdiff_t>(at[index]);
      const auto found = std::lower_bound(begin, line.times.end(), time);
      return static_cast<std::size_t>(found - line.times.begin());
    };
    const std::size_t first = place_of(from);
    if (first != at[index]) levels_[index] = level(first - 1);
    at[index] = first;
    const std::size_t end = place_of(to);
    for (; at[index] != end; ++at[index]) {
      held_.push_back({picoseconds(line.times[at[index]]), index, level(at[index])});
    }
    return static_cast<std::ptrdiff_t>(held_.size());
  };
  const auto begin = static_cast<std::ptrdiff_t>(held_.size());
  const std::ptrdiff_t slo = append(0, changes.ma);
  append(1, changes.slo);
  std::inplace_merge(held_.begin() + begin, held_.begin() + slo, held_.end(), is_earlier);
}

void Excerpt::add(ExcerptCycle cycle) {
  std::int64_t from = before_all;
  if (pending_) {
    const std::int64_t time = cycle.time.count;
    const std::int64_t before = pending_->cycle.time.count;
    from = time - std::min(lead_max, std::max<std::int64_t>(0, (time - before) / 2));
    pending_->wanted = pending_->wanted || cycle.chosen;
    queue(from);
  }
  const bool wanted = chosen_before_ || cycle.chosen;
  pending_ = Pending{std::move(cycle), from, wanted};
}

void Excerpt::queue(std::int64_t to) {
  chosen_before_ = pending_->cycle.chosen;
  if (pending_->wanted) queue_.emplace_back(std::move(*pending_), to);
}

// Copies the edges of the added cycles.
void Excerpt::settle() {
  for (auto& [window, to] : queue_) copy(window, to);
  queue_.clear();
  std::int64_t keep = needed_from();
  if (held_.size() > held_max) keep = dropped_to_ = held_.back().time.count;
  leave(keep);
  held_.erase(held_.begin(), held_.begin() + left_);
  left_ = 0;
}

// Drops edges before this time, which are no longer needed.
void Excerpt::leave(std::int64_t time) {
  const auto end = static_cast<std::ptrdiff_t>(held_.size());
  for (; left_ < end; ++left_) {
    const Edge& edge = held_[static_cast<std::size_t>(left_)];
    if (edge.time.count >= time) return;
    levels_[edge.line] = edge.level;
  }
}

void Excerpt::copy(Pending& window, std::int64_t to) {
  leave(window.from);
  const auto begin = held_.begin() + left_;
  const auto end =
      std::find_if(begin, held_.end(), [&](const Edge& edge) { return edge.time.count >= to; });
  const auto count = static_cast<std::size_t>(end - begin);
  const bool negative = window.cycle.time.count < 0 || (count != 0 && begin->time.count < 0);
  if (negative || window.from < dropped_to_ || edges_.size() + count > edges_max) {
    ++lost_;
    return;
  }
  if (last_to_ != window.from) {
    for (const wire::LineIndex line : {0U, 1U}) {
      if (last_to_ != before_all) edges_.push_back({picoseconds(last_to_), line, Level::unknown});
    }
    for (const wire::LineIndex line : {0U, 1U}) {
      const std::int64_t from = std::max<std::int64_t>(0, window.from);
      if (levels_[line] != Level::unknown)
        edges_.push_back({picoseconds(from), line, levels_[line]});
    }
  }
  edges_.insert(edges_.end(), begin, end);
  last_to_ = to;
  cycles_.push_back(std::move(window.cycle));
  ends_.emplace_back(edges_.size(), to);
}

void Excerpt::finish(Picoseconds end) {
  end_ = end.count;
  if (pending_) queue(end.count + 1);
  pending_.reset();
  settle();
}

std::string Excerpt::vcd(std::size_t count) const {
  std::string text;
  capture::StringSink bytes(text);
  capture::VcdWriter writer({"MA", "SLO"}, bytes);
  if (count != 0) {
    const auto [edges, to] = ends_[count - 1];
    std::vector<Edge> part(edges_.begin(), edges_.begin() + static_cast<std::ptrdiff_t>(edges));
    for (const wire::LineIndex line : {0U, 1U}) {
      if (to <= end_) part.push_back({picoseconds(to), line, Level::unknown});
    }
    if (!writer.write(part).ok()) return {};
  }
  if (!writer.finish(picoseconds(end_)).ok()) return {};
  return text;
}

}  // namespace biss::verbs
