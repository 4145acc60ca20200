// `--fault`: what damages the line, in which cycles, and where in them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "sim/fault_schedule.hpp"

namespace biss::cli {

/// `KIND:RATE`, a share of cycles, or `KIND@CYCLE`; behind it may stand `,bit=N` or `,clock=N`, N
/// with up to three decimals. \return an empty text, or why it is none of these
std::string read_fault(const std::string& text, sim::FaultRule& rule);

/// Whether the rules fit this line: each names a cycle and a place that exist, and no two strike
/// one cycle with one kind.
/// \return an empty text, or the one line why not
std::string check_faults(std::span<const sim::FaultRule> rules, const sim::NominalCycle& nominal,
                         std::uint64_t cycles);

/// All kinds, a comma between two.
std::string fault_kinds_text();

/// Where faults began, as `flip@bit=7;cut@clock=12.25`; what it was drawn to be included.
std::string text_of(std::span<const sim::FaultStrike> strikes);

}  // namespace biss::cli
