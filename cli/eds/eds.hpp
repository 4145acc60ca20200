// The verbs of `biss eds`, one file each: see cli/common/verb.hpp.
#pragma once

#include "cli/common/verb.hpp"

namespace biss::cli {

Run add_eds_show(Verb verb);
Run add_eds_check(Verb verb);
Run add_eds_build(Verb verb);
Run add_eds_diff(Verb verb);
Run add_eds_advise(Verb verb);

}  // namespace biss::cli
