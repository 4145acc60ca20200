// Verbs below a verb: `biss eds show`, `biss safety analyse`.
#pragma once

#include <vector>

#include "cli/common/verb.hpp"

namespace biss::cli {

/// One of them. `add` declares its options; what it returns runs it once it was chosen.
struct GroupVerb {
  VerbText text;
  Run (*add)(CLI::App& verb);
};

/// Adds `biss GROUP` with its verbs, of which one has to be given.
void add_verb_group(Command& command, const VerbText& group, const std::vector<GroupVerb>& verbs);

}  // namespace biss::cli
