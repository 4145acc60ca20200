// The verbs of `biss safety`, one file each.
#pragma once

#include <functional>

#include "tools/exit_status.hpp"

namespace CLI {
class App;
}

namespace biss::tools {

/// Adds a verb below `safety`; what is returned runs it once it was chosen.
using SafetyRun = std::function<ExitStatus()>;

SafetyRun add_safety_analyse(CLI::App& verb);
SafetyRun add_safety_campaign(CLI::App& verb);
SafetyRun add_safety_sequences(CLI::App& verb);
SafetyRun add_safety_evidence(CLI::App& verb);

}  // namespace biss::tools
