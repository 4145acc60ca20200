// What other verbs of the command say of the same capture.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "cli/common/message.hpp"

namespace biss::cli {

/// Runs the command with these words in a process of its own.
/// \return `status`, `out` and `err`, as RunResult of wasm/biss.d.mts; `io` where it cannot be run
tl::expected<nlohmann::json, VerbError> ask_command(const std::vector<std::string>& words);

}  // namespace biss::cli
