// The summary of a capture, in a few lines for a reader.
#pragma once

#include <string>
#include <string_view>

#include "decode/safety_watch.hpp"
#include "decode/statistics.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// \param capture the capture that has been read
/// \param safety null without a monitor; `safety_name` is the name of its configuration
std::string decode_summary(const decode::Statistics& statistics, const DecodedCapture& capture,
                           const decode::SafetyWatch* safety, std::string_view safety_name);

}  // namespace biss::verbs
