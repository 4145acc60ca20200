// Accesses to registers, and commands, as rows: those of `biss registers`.
#pragma once

#include <vector>

#include "decode/control_listener.hpp"
#include "report/table.hpp"

namespace biss::verbs {

/// The columns. The first one is the number of the cycle in which an access begins; `cycles` says how
/// many it takes.
const std::vector<report::Column>& access_columns();

/// A row; of a command to several slaves a row for each. A broadcast, and what a damaged header leaves
/// open, has no ID.
void write_access(report::TableWriter& writer, const decode::SeenAccess& access);

}  // namespace biss::verbs
