// What is known about a capture before its cause is looked for: how it reads, and what it carries.
#pragma once

#include "cli/common/decoded_capture.hpp"
#include "explain/diagnose.hpp"

namespace biss::cli {

/// How the lines of a capture read best. \pre as DecodedCapture::beginning()
explain::Reading choose_reading(DecodedCapture& capture, const CaptureArguments& arguments);

/// What diagnose() needs beside the cycles. \pre as DecodedCapture::beginning()
explain::Context explain_context(DecodedCapture& capture, const CaptureArguments& arguments,
                                 const MarginArguments& margin);

}  // namespace biss::cli
