// The verbs of `biss eds`, one file each: see verb_group.hpp.
#pragma once

#include "cli/common/verb.hpp"

namespace biss::cli {

Run add_eds_show(CLI::App& verb);
Run add_eds_check(CLI::App& verb);
Run add_eds_build(CLI::App& verb);
Run add_eds_diff(CLI::App& verb);
Run add_eds_advise(CLI::App& verb);

}  // namespace biss::cli
