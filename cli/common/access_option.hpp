// `--access`: what the simulated master does over the control communication.
#pragma once

#include <string>
#include <vector>

#include "cli/common/exit_status.hpp"
#include "sim/control_master.hpp"

namespace biss::cli {

/// One access:
///
///   [ID/]read:ADDRESS[,COUNT]
///   [ID/]write:ADDRESS=BYTES            BYTES: two hexadecimal digits each
///   [ID[,ID…]/]command:NAME[,WHEN]      without ID a broadcast
///
/// Behind each of them may stand @CYCLE, which it waits for. ID is 0 to 7, 0 where it is left out;
/// NAME channels, control, bypass, user or the number 0 to 3; WHEN all, any or always: of the
/// addressed slaves, who must accept.
/// \return an empty text, or the one line why it is none of these
std::string read_access(const std::string& text, sim::ControlAccess& access);

/// Accesses in order; `@FILE` stands for those in a file, one a line, `#` before remarks.
struct AccessChoice {
  std::vector<sim::ControlAccess> accesses;
  std::string error;  ///< one line, or empty
  ExitStatus status = ExitStatus::done;
};
AccessChoice read_accesses(const std::vector<std::string>& texts);

/// Cycles that they take at least, one after the other.
std::uint64_t least_cycles(const std::vector<sim::ControlAccess>& accesses);

/// channels, control, bypass, user.
const char* name_of(ControlCommand command);

}  // namespace biss::cli
