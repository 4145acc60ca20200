// Changes of two lines as edges, for a piece with too many changes for arrays.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "capture/pair_source.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// Follows the levels of two lines, so that each change becomes one edge.
class ChangeEdges {
 public:
  ChangeEdges(wire::LineIndex ma, wire::LineIndex slo) : ma_{ma, {}}, slo_{slo, {}} {}

  /// The levels before the next changes.
  void set(bool ma_high, bool slo_high) {
    ma_.level = ma_high ? wire::Level::high : wire::Level::low;
    slo_.level = slo_high ? wire::Level::high : wire::Level::low;
  }
  /// These changes were delivered as arrays.
  void skip(const LineChanges& ma, const LineChanges& slo) {
    skip(ma_, ma);
    skip(slo_, slo);
  }
  /// Delivers these changes in the order of their times. If both lines change at the same time, SLO
  /// comes first.
  void put(const LineChanges& ma, const LineChanges& slo, const PairSource::OnEdges& on_edges) {
    edges_.clear();
    std::size_t at = 0;
    for (std::size_t i = 0; i < ma.times.size(); ++i) {
      for (; at < slo.times.size() && slo.times[at] <= ma.times[i]; ++at) put(slo_, slo, at);
      put(ma_, ma, i);
    }
    for (; at < slo.times.size(); ++at) put(slo_, slo, at);
    on_edges(edges_);
  }

 private:
  struct Line {
    wire::LineIndex index;
    std::optional<wire::Level> level;
  };
  static void skip(Line& line, const LineChanges& changes) {
    if (!changes.times.empty()) line.level = changes.run().level(changes.times.size() - 1);
  }
  void put(Line& line, const LineChanges& changes, std::size_t i) {
    const wire::Level level = changes.run().level(i);
    if (line.level == level) return;
    line.level = level;
    edges_.push_back({Picoseconds{changes.times[i]}, line.index, level});
  }

  Line ma_;
  Line slo_;
  std::vector<wire::Edge> edges_;
};

}  // namespace biss::capture
