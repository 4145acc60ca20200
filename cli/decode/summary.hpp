// What a capture adds up to, in a few lines for eyes.
#pragma once

#include <string>
#include <vector>

#include "cli/decode/safety.hpp"
#include "decode/cycle_reader.hpp"
#include "decode/lines.hpp"
#include "decode/statistics.hpp"

namespace biss::cli {

/// \param capture what the user called it
/// \param lines the names of the capture's lines
/// \param margin what `marginal` was judged by
/// \param safety null where there is no monitor; `safety_name` is its configuration's
std::string decode_summary(const decode::Statistics& statistics, const std::string& capture,
                           const std::vector<std::string>& lines, const decode::FoundLines& found,
                           const decode::MarginSetup& margin, const SafetyWatch* safety,
                           std::string_view safety_name);

}  // namespace biss::cli
