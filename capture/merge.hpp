// Several captures as one: MA from one file, SLO from another.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"

namespace biss::capture {

/// A capture and its name, usually its path.
struct NamedSource {
  std::unique_ptr<EdgeSource> source;
  std::string name;
};

/// An EdgeSource over several, whose times must count from the same moment.
///
/// The lines of the first source come first, then the lines of the second, and so on. Each is
/// called `source:name`. Edges of the same time come in the order of the sources. When a source
/// fails, everything before the time it reached is delivered first, then its error. The end of
/// samples is known: if a source of samples ends before the others, its lines have no level from
/// there on. Lines of changes keep their last level.
class MergedSource final : public EdgeSource {
 public:
  /// \pre no source is null and none has been read from
  explicit MergedSource(std::vector<NamedSource> sources) {
    for (NamedSource& named : sources) {
      const auto first_line = static_cast<wire::LineIndex>(lines_.size());
      for (const std::string& line : named.source->lines()) {
        lines_.push_back(named.name + ':' + line);
      }
      inputs_.push_back({std::move(named.source), first_line, {}, false});
    }
    lines_ = unique_names(std::move(lines_));
    levels_.assign(lines_.size(), no_level);
  }

  const std::vector<std::string>& lines() const override { return lines_; }

  Result<std::span<const wire::Edge>, CaptureError> next_block() override {
    block_.clear();
    while (!error_ && block_.size() < block_edges && fill()) {
      Input* const input = earliest();
      if (input == nullptr) break;
      wire::Edge edge = input->ahead.front();
      input->ahead = input->ahead.subspan(1);
      edge.line += input->first_line;
      levels_[edge.line] = static_cast<std::uint8_t>(edge.level);
      block_.push_back(edge);
      last_ = edge.time;
    }
    if (block_.empty() && error_) return failure(*error_);
    return std::span<const wire::Edge>(block_);
  }

  /// The largest of the sources' end times; after an error, the time up to which all of them were
  /// read.
  Picoseconds end_time() const override {
    if (error_) return std::max(last_, read_to());
    const auto latest = std::max_element(
        inputs_.begin(), inputs_.end(),
        [](const Input& a, const Input& b) { return a.source->end_time() < b.source->end_time(); });
    return latest == inputs_.end() ? Picoseconds{} : latest->source->end_time();
  }

  /// The longest of the sources' sample periods.
  Picoseconds sample_period() const override {
    Picoseconds longest{};
    for (const Input& input : inputs_) longest = std::max(longest, input.source->sample_period());
    return longest;
  }

  /// The rate of all sources; 0 Hz if they differ.
  Hertz sample_rate() const override {
    const Hertz first = inputs_.empty() ? Hertz{} : inputs_.front().source->sample_rate();
    const bool same = std::all_of(inputs_.begin(), inputs_.end(), [first](const Input& input) {
      return input.source->sample_rate() == first;
    });
    return same ? first : Hertz{};
  }

  /// True if any source is analog.
  bool is_analog() const override {
    return std::any_of(inputs_.begin(), inputs_.end(),
                       [](const Input& input) { return input.source->is_analog(); });
  }

  /// Which source the error of next_block() comes from.
  std::size_t failed_source() const { return failed_source_; }

 private:
  struct Input {
    std::unique_ptr<EdgeSource> source;
    wire::LineIndex first_line = 0;
    std::span<const wire::Edge> ahead;
    bool ended = false;
    // After the end of samples: no level on any line. The last edges ahead.
    std::vector<wire::Edge> unknown{};
  };

  static constexpr std::size_t block_edges = 8'192;

  // Sees to it that every source that has not ended has edges ahead; false when one failed.
  bool fill() {
    for (Input& input : inputs_) {
      if (input.ended || !input.ahead.empty()) continue;
      const auto block = input.source->next_block();
      if (!block.ok()) {
        error_ = block.error();
        failed_source_ = static_cast<std::size_t>(&input - inputs_.data());
        return false;
      }
      input.ahead = *block;
      if (block->empty()) end(input);
    }
    return true;
  }

  void end(Input& input) {
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
  Input* earliest() {
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

  // Before this time no edge is missing.
  Picoseconds read_to() const {
    Picoseconds to{std::numeric_limits<std::int64_t>::max()};
    for (const Input& input : inputs_) {
      if (input.ended) continue;
      to = std::min(to, input.ahead.empty() ? input.source->end_time() : input.ahead.front().time);
    }
    return to;
  }

  std::vector<Input> inputs_;
  std::vector<std::string> lines_;
  std::vector<std::uint8_t> levels_;  // of the edges delivered, or no_level
  std::vector<wire::Edge> block_;
  Picoseconds last_{std::numeric_limits<std::int64_t>::min()};  // of the edges delivered
  std::optional<CaptureError> error_;
  std::size_t failed_source_ = 0;
};

}  // namespace biss::capture
