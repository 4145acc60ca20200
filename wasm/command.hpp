// The verbs of the command, for a page.
#pragma once

#include <span>

#include "cli/common/exit_status.hpp"

namespace biss::wasm {

/// Runs `biss VERB …` on the files in memory. \param arguments the first one is the name of the
///   command
cli::ExitStatus run_command(std::span<const char* const> arguments);

}  // namespace biss::wasm
