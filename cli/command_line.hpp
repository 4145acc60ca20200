// A command line, which CLI11 splits into words and values.
#pragma once

#include "verbs/common/verb.hpp"

namespace biss::cli {

/// Runs the verb that the words name: see verbs::Command::run().
verbs::ExitStatus run_command_line(verbs::Command& command, int argc, const char* const* argv);

}  // namespace biss::cli
