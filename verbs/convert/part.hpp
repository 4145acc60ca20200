// The part of a capture that is converted: some of its lines, some of its time.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/units.hpp"
#include "wire/edge.hpp"

namespace biss::verbs {

/// Lines of a capture under the names that they get.
struct LineSelection {
  std::vector<std::string> names;
  /// For each line of the capture, its place among `names`.
  std::vector<std::optional<wire::LineIndex>> places;
};

/// The names of a capture's lines without the file before them, `FILE:NAME`, unless two would then be
/// the same.
std::vector<std::string> plain_names(const std::vector<std::string>& lines,
                                     const std::vector<std::string>& files);

/// The lines `wanted` in this order; every line when it is empty. Each is NAME, or NAME=NEW to rename
/// it.
/// \return why there is no such selection: one line without a line feed
tl::expected<LineSelection, std::string> select_lines(const std::vector<std::string>& lines,
                                                      const std::vector<std::string>& wanted);

/// Cuts the selected lines and a time range out of a stream of edges.
///
/// At the begin of the range every line gets the level that it has there. Edges after its end are
/// dropped. Edges with the same time are in the order of the selected lines.
class PartCutter {
 public:
  PartCutter(LineSelection selection, std::optional<Picoseconds> since,
             std::optional<Picoseconds> until);

  const std::vector<std::string>& names() const { return selection_.names; }

  /// The edges of the part in the next block; valid until the next call.
  std::span<const wire::Edge> push(std::span<const wire::Edge> block);
  /// The capture, which ends at this time, ends before the range begins.
  bool is_before(Picoseconds end_time) const;
  /// Edges have come that are later than the range.
  bool past_end() const { return past_end_; }
  /// The edges that are still due when the capture has ended.
  std::span<const wire::Edge> finish(Picoseconds end_time);
  /// The end of the part, in a capture that ends at `end_time`.
  Picoseconds end_of(Picoseconds end_time) const;

 private:
  void begin_range();

  LineSelection selection_;
  std::optional<Picoseconds> since_;
  std::optional<Picoseconds> until_;
  bool in_range_;
  bool reordered_;
  bool past_end_ = false;
  std::vector<std::optional<wire::Level>> levels_;  // up to the begin of the range
  std::vector<wire::Edge> part_;
};

}  // namespace biss::verbs
