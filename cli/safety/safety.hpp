// The verbs of `biss safety`, one file each: see cli/common/verb.hpp.
#pragma once

#include "cli/common/verb.hpp"

namespace biss::cli {

Run add_safety_analyse(Verb verb);
Run add_safety_campaign(Verb verb);
Run add_safety_sequences(Verb verb);
Run add_safety_evidence(Verb verb);

}  // namespace biss::cli
