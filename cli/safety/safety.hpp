// The verbs of `biss safety`, one file each: see verb_group.hpp.
#pragma once

#include "cli/common/verb.hpp"

namespace biss::cli {

Run add_safety_analyse(CLI::App& verb);
Run add_safety_campaign(CLI::App& verb);
Run add_safety_sequences(CLI::App& verb);
Run add_safety_evidence(CLI::App& verb);

}  // namespace biss::cli
