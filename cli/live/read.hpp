// `biss read`: the positions of a real line.
#pragma once

#include "verbs/common/verb.hpp"

namespace biss::cli {

void add_read(verbs::Command& command);

}  // namespace biss::cli
