// `--shard K/N`: one of N parts of the work.
#pragma once

#include <string>

#include "lab/shard.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// Declares the option; `shard` must live until the command line is parsed.
Option add_shard_option(Verb verb, lab::Shard& shard, const std::string& description);

}  // namespace biss::verbs
