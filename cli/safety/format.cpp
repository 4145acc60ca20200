#include "cli/safety/format.hpp"

#include <fmt/format.h>

#include "cli/common/format_option.hpp"

namespace biss::cli {

const SafetyConfiguration* implied_configuration(std::string_view text, const FrameFormat& format) {
  if (const SafetyConfiguration* named = find_safety_configuration(text)) return named;
  FrameFormat plain = format;
  for (const SafetyConfiguration& each : safety_configurations) {
    const FrameFormat known = each.frame_format();
    plain.cds0 = known.cds0;
    if (plain == known) return &each;
  }
  return nullptr;
}

bool is_safety_format(const FrameFormat& format) {
  return format.channel_count == 2 && !check_safety(format, SafetySetup{});
}

std::optional<SafetyFormat> parse_safety_format(std::string_view text) {
  if (const SafetyConfiguration* known = find_safety_configuration(text)) {
    return SafetyFormat{known->frame_format(), known->setup};
  }
  const DeviceChoice choice = parse_device(text);
  if (!choice || !is_safety_format(choice.device->format)) return std::nullopt;
  SafetyFormat found{choice.device->format, {}};
  if (choice.device->entry != nullptr) {
    const SafetyConfiguration* implied = implied_configuration(text, found.format);
    if (implied != nullptr) found.setup = implied->setup;
  }
  return found;
}

std::string safety_format_error(std::string_view text) {
  const DeviceChoice choice = parse_device(text);
  if (!choice) return choice.error;
  return fmt::format(
      "'{}' is neither a safety configuration such as fs-36-28 nor the format of a control and a "
      "safety word that can be monitored",
      text);
}

}  // namespace biss::cli
