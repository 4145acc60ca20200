// The verbs of `biss eds`, one file each.
#pragma once

#include <functional>

#include "tools/exit_status.hpp"

namespace CLI {
class App;
}

namespace biss::tools {

/// Adds a verb below `eds`; what is returned runs it once it was chosen.
using EdsRun = std::function<ExitStatus()>;

EdsRun add_eds_show(CLI::App& verb);
EdsRun add_eds_check(CLI::App& verb);
EdsRun add_eds_build(CLI::App& verb);
EdsRun add_eds_diff(CLI::App& verb);
EdsRun add_eds_advise(CLI::App& verb);

}  // namespace biss::tools
