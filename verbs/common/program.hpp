// The name and version of this program.
#pragma once

#include <string>

namespace biss::verbs {

/// The commit that the program was built from, with `-dirty` if files were changed; empty if it is
/// not known.
extern const char* const build_commit;

/// Name, version and, if known, commit, separated by spaces.
std::string program_text();

}  // namespace biss::verbs
