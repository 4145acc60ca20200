// `biss emulate`: a simulated encoder as a spidev device. Only the command has it.
#pragma once

#include "verbs/common/verb.hpp"

namespace biss::cli {

void add_emulate(verbs::Command& command);

}  // namespace biss::cli
