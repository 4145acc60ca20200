// The tables of docs/faults.md, the list of faults, and of lab/reports/faults.md, the results of
// decoding cycles with each fault.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "tests/sim/campaign.hpp"

namespace biss::campaign {

/// The line of the document: a 26-bit RESOLUTE at 10 MHz over 20 m, every kind of fault in 1.2 % of
/// cycles.
sim::LineSetup documented_line();

inline constexpr std::uint64_t documented_cycles = 1'000'000;

/// Returns the results as Markdown tables.
std::string fault_table(const Outcome& outcome);

/// Returns rows `first` to `last` - 1 of sim::fault_list as a Markdown table.
std::string fault_list(std::size_t first, std::size_t last);

/// Returns the places that each kind takes as a Markdown table.
std::string place_table();

}  // namespace biss::campaign
