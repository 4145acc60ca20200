// A device and its timing as a user writes them: `-f FORMAT` and the options of device timing.
#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "biss/configure/named_device.hpp"

namespace biss {

/// The values of the options as text; empty if not given.
struct FormatArguments {
  std::string format;
  std::string ack_max;
  std::string ack_clocks;
  std::string timeout;
  std::string release;
  std::string clock_max;
  std::string cycle_min;
};

/// The same as read_device(), but the error is one line (usage: exit status 2).
tl::expected<Device, std::string> parse_device(std::string_view format);

/// Reads the format and all timing options. \pre arguments.format is given
tl::expected<Device, std::string> choose_device(const FormatArguments& arguments);

/// Applies the timing options alone to `timing`, for a verb that works without a format.
tl::expected<DeviceTiming, std::string> override_timing(const FormatArguments& arguments,
                                                        DeviceTiming timing);

/// `adaptive`, `adaptive:680ns`, `static:20us`, `cycle:31.25us`; the text parses to the same rule.
std::string text_of(const Timeout& timeout);

/// Names of encoders and safety configurations close to `name`: at most three that begin with it,
/// else the name with the fewest typing errors; empty when none is close.
std::string suggested_encoders(std::string_view name);

}  // namespace biss
