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
}

// Sees to it that every source that has not ended has edges ahead; false when one failed.
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
    input.ended = block->empty();
  }
  return true;
}

MergedSource::Input* MergedSource::earliest() {
  Input* first = nullptr;
  for (Input& input : inputs_) {
    if (input.ahead.empty()) continue;
    if (first == nullptr || input.ahead.front().time < first->ahead.front().time) first = &input;
  }
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
    block_.push_back(edge);
  }
  if (block_.empty() && failed_) return failure(error_);
  return std::span<const wire::Edge>(block_);
}

Picoseconds MergedSource::end_time() const {
  Picoseconds latest;
  bool any = false;
  for (const Input& input : inputs_) {
    const Picoseconds end = input.source->end_time();
    latest = any ? std::max(latest, end) : end;
    any = true;
  }
  return latest;
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
