// The verbs of `biss eds`, one file each: see verbs/common/verb.hpp.
#pragma once

#include "verbs/common/verb.hpp"

namespace biss::verbs {

Run add_eds_show(Verb verb);
Run add_eds_check(Verb verb);
Run add_eds_build(Verb verb);
Run add_eds_diff(Verb verb);
Run add_eds_advise(Verb verb);

}  // namespace biss::verbs
