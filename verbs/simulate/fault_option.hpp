// `--fault`: the faults to inject, their cycles, and their places in a cycle.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "sim/fault_schedule.hpp"

namespace biss::verbs {

/// Reads `KIND:RATE`, a share of cycles, or `KIND@CYCLE`. Either may end with `,bit=N` or
/// `,clock=N`, N with up to three decimal places. The error is one line.
tl::expected<sim::FaultRule, std::string> read_fault(const std::string& text);

/// Checks the rules against this line: each names a cycle and a place that exist, and no two inject
/// one kind into one cycle. \return one line with the error, or an empty text
std::string wrong_faults(std::span<const sim::FaultRule> rules, const sim::NominalCycle& nominal,
                         std::uint64_t cycles);

/// The names of the kinds that are offered, separated by commas.
std::string fault_kinds_text(bool (*is_offered)(sim::FaultKind) = sim::is_injectable);

/// The places at which faults began, as `flip@bit=7;cut@clock=12.25`, chosen at random or given.
std::string text_of(std::span<const sim::InjectedFault> injected);

}  // namespace biss::verbs
