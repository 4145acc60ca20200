// The evidence of a likely cause, and what to do about it, as text with figures of the capture.
#pragma once

#include <string>

#include "explain/diagnose.hpp"

namespace biss::verbs {

/// Counts, times and cycles of this capture that support the cause.
std::string evidence_text(Cause cause, const explain::Evidence& evidence,
                          const explain::Context& context);

/// remedy_of(), with a figure of this capture if there is one.
std::string remedy_text(Cause cause, const explain::Evidence& evidence,
                        const explain::Context& context);

}  // namespace biss::verbs
