// What other verbs of the command say of the same capture.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "cli/common/host.hpp"

namespace biss::cli {

/// Runs `identify`, `explain` or `check` with these words in this process.
/// \return `status`, `out` and `err`, as RunResult of wasm/biss.d.mts; its own error where it could
///   not judge the capture
tl::expected<nlohmann::json, VerbError> ask_verb(const std::vector<std::string>& words, Host& host);

}  // namespace biss::cli
