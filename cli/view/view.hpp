// `biss view`: the page with one capture, or a line that is read now, served to this
// machine alone. Only the command has it.
#pragma once

#include "verbs/common/verb.hpp"

namespace biss::cli {

void add_view(verbs::Command& command);

}  // namespace biss::cli
