// `--access`: register accesses and commands of the simulated master.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "sim/control_master.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {

/// The most accesses of one run; far more than the longest capture has time for.
inline constexpr std::size_t max_accesses = 1'000'000;

/// Reads one access, or returns one line with the mistake in the text:
///
///   [ID/]read:ADDRESS[,COUNT]
///   [ID/]write:ADDRESS=BYTES            BYTES: two hexadecimal digits each
///   [ID[,ID…]/]command:NAME[,WHEN]      without ID a broadcast
///
/// Each may end with @CYCLE: the access does not start before that cycle. ID is 0 to 7, by default
/// 0. NAME is channels, control, bypass, user or the number 0 to 3. WHEN: which of the addressed
/// slaves must accept the command before it is executed: all (the default), any, or always (none).
tl::expected<sim::ControlAccess, std::string> read_access(const std::string& text);

/// Reads accesses in order. `@FILE` stands for the accesses in a file (`@-`: standard input), one
/// per line of at most dump::max_line_bytes, with comments after `#`. Throws a VerbError: a mistake
/// in the file is `io` and names the line.
std::vector<sim::ControlAccess> read_accesses(const std::vector<std::string>& texts);

/// FILE of `@FILE`; empty for an access.
std::string file_of_accesses(const std::string& text);

/// The fewest cycles that they take, one after the other.
std::uint64_t least_cycles(const std::vector<sim::ControlAccess>& accesses);

/// channels, control, bypass, user.
const char* name_of(ControlCommand command);

}  // namespace biss::verbs
