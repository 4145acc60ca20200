#include "verbs/convert/part.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

namespace biss::verbs {

std::vector<std::string> plain_names(const std::vector<std::string>& lines,
                                     const std::vector<std::string>& files) {
  if (files.size() < 2) return lines;
  std::vector<std::string> plain;
  std::set<std::string> different;
  for (const std::string& line : lines) {
    std::size_t prefix = 0;
    for (const std::string& file : files) {
      if (line.starts_with(file + ':')) prefix = std::max(prefix, file.size() + 1);
    }
    plain.push_back(line.substr(prefix));
    different.insert(plain.back());
  }
  return different.size() == lines.size() ? plain : lines;
}

tl::expected<LineSelection, std::string> select_lines(const std::vector<std::string>& lines,
                                                      const std::vector<std::string>& wanted) {
  LineSelection selection;
  selection.places.resize(lines.size());
  const auto index_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(lines.begin(), lines.end(), name) - lines.begin());
  };
  for (const std::string& text : wanted.empty() ? lines : wanted) {
    std::string name = text;
    std::string renamed = text;
    const std::size_t equals = text.rfind('=');
    if (index_of(text) == lines.size() && equals != std::string::npos) {
      name = text.substr(0, equals);
      renamed = text.substr(equals + 1);
    }
    const std::size_t line = index_of(name);
    if (line == lines.size()) {
      return tl::unexpected(
          fmt::format("--line: no line '{}'; the capture has {}", name, fmt::join(lines, ", ")));
    }
    const bool name_taken =
        std::find(selection.names.begin(), selection.names.end(), renamed) != selection.names.end();
    if (selection.places[line] || renamed.empty() || name_taken) {
      return tl::unexpected(fmt::format("--line: '{}' names a line twice, or with no name", text));
    }
    selection.places[line] = static_cast<wire::LineIndex>(selection.names.size());
    selection.names.push_back(renamed);
  }
  return selection;
}

PartCutter::PartCutter(LineSelection selection, std::optional<Picoseconds> since,
                       std::optional<Picoseconds> until)
    : selection_(std::move(selection)),
      since_(since),
      until_(until),
      in_range_(!since),
      reordered_(!std::is_sorted(selection_.places.begin(), selection_.places.end())),
      levels_(selection_.names.size()) {}

void PartCutter::begin_range() {
  in_range_ = true;
  for (std::size_t line = 0; line < levels_.size(); ++line) {
    if (levels_[line])
      part_.push_back({*since_, static_cast<wire::LineIndex>(line), *levels_[line]});
  }
}

std::span<const wire::Edge> PartCutter::push(std::span<const wire::Edge> block) {
  part_.clear();
  for (wire::Edge edge : block) {
    if (until_ && edge.time > *until_) {
      past_end_ = true;
      break;
    }
    const auto place = selection_.places[edge.line];
    if (!in_range_ && edge.time > *since_) begin_range();
    if (!place) continue;
    edge.line = *place;
    if (in_range_) {
      part_.push_back(edge);
    } else {
      levels_[edge.line] = edge.level;
    }
  }
  if (reordered_) {
    std::stable_sort(part_.begin(), part_.end(), [](const wire::Edge& a, const wire::Edge& b) {
      return a.time != b.time ? a.time < b.time : a.line < b.line;
    });
  }
  return part_;
}

bool PartCutter::is_before(Picoseconds end_time) const {
  return since_ && !past_end_ && end_time < *since_;
}

std::span<const wire::Edge> PartCutter::finish(Picoseconds end_time) {
  part_.clear();
  if (!in_range_ && !is_before(end_time)) begin_range();
  return part_;
}

Picoseconds PartCutter::end_of(Picoseconds end_time) const {
  if (!until_) return end_time;
  return past_end_ ? *until_ : std::min(end_time, *until_);
}

}  // namespace biss::verbs
