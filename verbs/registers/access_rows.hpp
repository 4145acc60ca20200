// Accesses to registers, and commands, as the rows of `biss registers`.
#pragma once

#include <vector>

#include "decode/control_listener.hpp"
#include "report/table.hpp"

namespace biss::verbs {

/// The columns. The first one is the number of the cycle in which an access begins; `cycles` is the
/// number of its cycles.
std::vector<report::Column> access_columns();

/// Writes a row, or a row for each slave of a command to several slaves. The ID is empty for a
/// broadcast, and if a damaged header leaves it open.
void write_access(report::TableWriter& writer, const decode::SeenAccess& access);

}  // namespace biss::verbs
