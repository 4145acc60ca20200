#include "capture/merge.hpp"

#include <algorithm>
#include <utility>

#include "capture/edge_source.hpp"

namespace biss::capture {

MergedSource::MergedSource(std::vector<NamedSource> sources) {
  LineNames names;
  for (NamedSource& named : sources) {
    const auto first_line = static_cast<wire::LineIndex>(lines_.size());
    for (const std::string& line : named.source->lines()) {
      lines_.push_back(names.claim(named.name + ':' + line));
    }
    inputs_.push_back({std::move(named.source), first_line, {}, false});
  }
  levels_.assign(lines_.size(), no_level);
}

// Makes sure that every source that has not ended has edges ahead; false when one failed.
bool MergedSource::fill() {
  for (Input& input : inputs_) {
    if (input.ended || !input.ahead.empty()) continue;
    const auto block = input.source->next_block();
    if (!block.ok()) {
      failed_ = true;
      error_ = block.error();
      failed_source_ = static_cast<std::size_t>(&input - inputs_.data());
      return false;
    }
    input.ahead = *block;
    if (block->empty()) end(input);
  }
  return true;
}

void MergedSource::end(Input& input) {
  input.ended = true;
  if (input.source->sample_period() == Picoseconds{}) return;
  const Picoseconds time = input.source->end_time();
  for (wire::LineIndex line = 0; line < input.source->lines().size(); ++line) {
    constexpr auto unknown = static_cast<std::uint8_t>(wire::Level::unknown);
    if (levels_[input.first_line + line] == unknown) continue;
    input.unknown.push_back({time, line, wire::Level::unknown});
  }
  input.ahead = input.unknown;
}

// If two have the same time, the first one; but the end of a source comes last.
MergedSource::Input* MergedSource::earliest() {
  const auto before = [](const Input& a, const Input& b) {
    const Picoseconds time = a.ahead.front().time;
    const Picoseconds other = b.ahead.front().time;
    return time < other || (time == other && !a.ended && b.ended);
  };
  Input* first = nullptr;
  for (Input& input : inputs_) {
    if (input.ahead.empty()) continue;
    if (first == nullptr || before(input, *first)) first = &input;
  }
  // Nothing comes after the end of the longest one.
  if (first != nullptr && first->ended && first->ahead.front().time >= end_time()) return nullptr;
  return first;
}

Result<std::span<const wire::Edge>, CaptureError> MergedSource::next_block() {
  block_.clear();
  while (!failed_ && block_.size() < block_edges && fill()) {
    Input* const input = earliest();
    if (input == nullptr) break;
    wire::Edge edge = input->ahead.front();
    input->ahead = input->ahead.subspan(1);
    edge.line += input->first_line;
    levels_[edge.line] = static_cast<std::uint8_t>(edge.level);
    block_.push_back(edge);
    last_ = edge.time;
  }
  if (block_.empty() && failed_) return failure(error_);
  return std::span<const wire::Edge>(block_);
}

// Before this time no edge is missing.
Picoseconds MergedSource::read_to() const {
  Picoseconds to{std::numeric_limits<std::int64_t>::max()};
  for (const Input& input : inputs_) {
    if (input.ended) continue;
    to = std::min(to, input.ahead.empty() ? input.source->end_time() : input.ahead.front().time);
  }
  return to;
}

Picoseconds MergedSource::end_time() const {
  if (failed_) return std::max(last_, read_to());
  const auto latest = std::max_element(
      inputs_.begin(), inputs_.end(),
      [](const Input& a, const Input& b) { return a.source->end_time() < b.source->end_time(); });
  return latest == inputs_.end() ? Picoseconds{} : latest->source->end_time();
}

Picoseconds MergedSource::sample_period() const {
  Picoseconds longest{};
  for (const Input& input : inputs_) longest = std::max(longest, input.source->sample_period());
  return longest;
}

Hertz MergedSource::sample_rate() const {
  const Hertz first = inputs_.empty() ? Hertz{} : inputs_.front().source->sample_rate();
  const bool same = std::all_of(inputs_.begin(), inputs_.end(), [first](const Input& input) {
    return input.source->sample_rate() == first;
  });
  return same ? first : Hertz{};
}

bool MergedSource::is_analog() const {
  return std::any_of(inputs_.begin(), inputs_.end(),
                     [](const Input& input) { return input.source->is_analog(); });
}

}  // namespace biss::capture
