// `-f FORMAT` and the options of device timing, for every verb that has them.
#pragma once

#include <cstdint>
#include <string>

#include "biss/frame/line_order.hpp"
#include "device/device_text.hpp"

namespace biss::verbs {

class Verb;

/// Declares `-f, --format`. \pre arguments outlives the parsing
/// \param more the text that the verb adds to the help of the option
void add_format_option(Verb verb, FormatArguments& arguments, bool required,
                       const std::string& more = {});
/// Declares `--ack-max`, `--ack-clocks`, `--timeout`, `--release`, `--clock-max`, `--cycle-min`.
void add_timing_options(Verb verb, FormatArguments& arguments);

/// `the format has no error bit (nE or E)`: no channel has a field of this kind, an error, a warning
/// or a sign of life. Empty if one has it.
std::string missing_field(const FrameFormat& format, FieldKind kind);

/// Why no daisy chain of N encoders can send this format: each needs its own channel. Empty if a
/// chain can.
std::string wrong_slaves(std::uint64_t slaves, const FrameFormat& format);

}  // namespace biss::verbs
