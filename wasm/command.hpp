// The verbs of the command, for a page.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "verbs/common/verb.hpp"

namespace biss::wasm {

/// A request for a verb by biss.mjs: the JSON object `{"words": ["decode", …], "options":
/// [["--format", ["pos26"]], …]}`, see verbs::Command::run().
struct Request {
  std::vector<std::string> words;
  verbs::GivenOptions options;

  explicit Request(std::string_view json);
};

/// Runs a verb on the files in memory.
verbs::ExitStatus run_command(std::string_view json);

/// The verbs and their options, as verbs::described() has them.
std::string described_verbs();

}  // namespace biss::wasm
