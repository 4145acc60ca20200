// The verbs of the command; each is defined in the file of its name.
#pragma once

namespace biss::tools {

class Command;

void add_decode(Command& command);
void add_simulate(Command& command);

}  // namespace biss::tools
