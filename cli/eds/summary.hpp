// What a data sheet makes of its encoder, for the block under a table.
#pragma once

#include <string>

#include "cli/eds/source.hpp"

namespace biss::cli {

/// Frame format, timing and everything that was doubtful on the way there, in lines.
std::string eds_summary(const EdsSource& source);

}  // namespace biss::cli
