// The facts about a capture that the search for a cause needs: its readings and its protocol.
#pragma once

#include <functional>

#include "explain/diagnose.hpp"
#include "verbs/common/decoded_capture.hpp"

namespace biss::verbs {

/// How the lines of a capture read best. \pre as DecodedCapture::beginning()
explain::Reading choose_reading(DecodedCapture& capture);

/// Reads the capture from its beginning by these lines and collects the evidence; `on_cycle` also
/// gets each cycle. \return as DecodedCapture::read() \pre as DecodedCapture::beginning()
bool observe(DecodedCapture& capture, const decode::Lines& lines,
             const std::function<void(const decode::Cycle& cycle)>& on_cycle,
             explain::Evidence& evidence);

/// The facts that diagnose() needs in addition to the cycles. \pre as DecodedCapture::beginning()
explain::Context explain_context(DecodedCapture& capture);

}  // namespace biss::verbs
