// `biss explain --cycle`: one cycle, bit by bit.
#pragma once

#include <string>
#include <vector>

#include "draw/cycle_drawing.hpp"
#include "report/table.hpp"

namespace biss::verbs {

/// The columns of a cycle's bits: one row per clock of MA.
std::vector<report::Column> drawing_columns();

/// Writes the rows. False when the writer has failed.
bool write_drawing(const draw::CycleDrawing& drawing, report::TableWriter& writer);

/// The head of the drawing: a description of the cycle in one or two lines.
std::string drawing_title(const draw::CycleDrawing& drawing);

}  // namespace biss::verbs
