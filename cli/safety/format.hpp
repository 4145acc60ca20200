// `-f FORMAT` where it is to be monitored: the frame and the safety configuration behind a text.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "biss/frame/format.hpp"
#include "biss/safety/configurations.hpp"

namespace biss::cli {

/// The configuration of that name, else the first one with the format's words whatever its CDS,
/// else null.
const SafetyConfiguration* implied_configuration(std::string_view text, const FrameFormat& format);

/// Two words, the second one with a sign of life of 6 bits, and all else that a monitor needs.
bool is_safety_format(const FrameFormat& format);

/// A frame and how it is monitored.
struct SafetyFormat {
  FrameFormat format;
  SafetySetup setup;
};

/// A safety configuration; a catalogue name, monitored as `decode` does it: by the configuration
/// that its name or its words imply; or the format of two words, with the defaults of SafetySetup.
/// \return none where it is none of these or cannot be monitored
std::optional<SafetyFormat> parse_safety_format(std::string_view text);

/// The one line why parse_safety_format() has none (usage: exit status 2).
std::string safety_format_error(std::string_view text);

}  // namespace biss::cli
