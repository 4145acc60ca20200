// The table of docs/faults.md: what becomes of cycles that suffer each fault.
#pragma once

#include <cstdint>
#include <string>

#include "tests/sim/campaign.hpp"

namespace biss::campaign {

/// The line that the document speaks of: a 26-bit RESOLUTE at 10 MHz over 20 m, every kind of fault
/// in 1.2 % of cycles.
sim::LineSetup documented_line();

inline constexpr std::uint64_t documented_cycles = 1'000'000;

/// Runs that line and makes the table, in Markdown.
std::string fault_table(const Outcome& outcome);

}  // namespace biss::campaign
