// The verbs of the command; each is defined in the file of its name.
#pragma once

namespace biss::tools {

class Command;

}  // namespace biss::tools
