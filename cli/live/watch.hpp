// `biss watch`: the health of a link over hours and days.
#pragma once

#include "verbs/common/verb.hpp"

namespace biss::cli {

void add_watch(verbs::Command& command);

}  // namespace biss::cli
