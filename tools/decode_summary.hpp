// What a capture adds up to, in a few lines for eyes.
#pragma once

#include <string>

#include "decode/lines.hpp"
#include "decode/statistics.hpp"

namespace biss::tools {

/// \param ma,slo the lines that were read
std::string decode_summary(const decode::Statistics& statistics, const std::string& capture,
                           const std::string& ma, const std::string& slo, decode::LineChoice how);

}  // namespace biss::tools
