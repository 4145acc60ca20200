// Mixed edges as the arrays of two lines, for sources that deliver edges only.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"

namespace biss::capture {

/// The changes of two lines among these edges. False if a level is unknown: arrays cannot represent
/// it.
bool take_changes(std::span<const wire::Edge> edges, wire::LineIndex ma, wire::LineIndex slo,
                  LineChanges& ma_changes, LineChanges& slo_changes);

/// These edges, then the rest of the source: by its own arrays if it has them, else by its edges.
/// The source must outlive the returned object.
std::unique_ptr<PairSource> pairs_of(std::vector<wire::Edge> edges, EdgeSource& source,
                                     wire::LineIndex ma, wire::LineIndex slo);

}  // namespace biss::capture
