// The verbs that this build has: the list is in verbs/CMakeLists.txt.
#pragma once

#include <string_view>

#include "verbs/common/verb.hpp"

namespace biss::verbs {

/// Adds the verb of this name; without a name, or if no verb has it, all of them.
void add_verbs(Command& command, std::string_view name = {});

}  // namespace biss::verbs
