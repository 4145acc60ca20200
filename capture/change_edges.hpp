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
    ma_.high = ma_high;
    slo_.high = slo_high;
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
    std::optional<bool> high;
  };

  static bool level(const LineChanges& changes, std::size_t i) {
    return changes.first_high == (i % 2 == 0);
  }
  static void skip(Line& line, const LineChanges& changes) {
    if (!changes.times.empty()) line.high = level(changes, changes.times.size() - 1);
  }
  void put(Line& line, const LineChanges& changes, std::size_t i) {
    const bool high = level(changes, i);
    if (line.high == high) return;
    line.high = high;
    edges_.push_back(
        {Picoseconds{changes.times[i]}, line.index, high ? wire::Level::high : wire::Level::low});
  }

  Line ma_;
  Line slo_;
  std::vector<wire::Edge> edges_;
};

}  // namespace biss::capture
