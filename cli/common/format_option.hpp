// `-f FORMAT` and the options of device timing, the same for every verb that has them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "biss/catalogue/entry.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss::cli {

class Verb;

/// What the user typed; empty where nothing.
struct FormatArguments {
  std::string format;
  std::string ack_max;
  std::string ack_clocks;
  std::string timeout;
  std::string release;
  std::string clock_max;
  std::string cycle_min;
};

/// Declares `-f, --format`. \pre arguments outlives the parsing
/// \param more what the verb adds to the help of the option
void add_format_option(Verb verb, FormatArguments& arguments, bool required,
                       const std::string& more = {});
/// Declares `--ack-max`, `--ack-clocks`, `--timeout`, `--release`, `--clock-max`, `--cycle-min`.
void add_timing_options(Verb verb, FormatArguments& arguments);

/// The encoder that a user describes: what its bits mean, how it behaves in time.
struct Device {
  FrameFormat format;
  /// From the catalogue where a name was given, else the widest that BiSS C allows; single options
  /// override.
  DeviceTiming timing;
  /// Null unless a catalogue name was given. Lives as long as the program.
  const CatalogueEntry* entry = nullptr;
};

/// A device, or one line that says why there is none (usage: exit status 2).
struct DeviceChoice {
  std::optional<Device> device;
  std::string error;

  explicit operator bool() const { return device.has_value(); }
};

/// Reads a format alone: the grammar, a catalogue name (`resolute-26`), the name of a safety
/// configuration (`rsm`), or a profile identifier (`bp3:0x621E`). A name that is both is the
/// catalogue's.
DeviceChoice parse_device(std::string_view format);

/// Reads the format and all timing options. \pre arguments.format is given
DeviceChoice choose_device(const FormatArguments& arguments);

/// The timing options alone, put over `timing`: for a verb that works without a format.
/// \return an empty text, or the one line why an option is wrong; `timing` is then half changed
std::string override_timing(const FormatArguments& arguments, DeviceTiming& timing);

/// `adaptive`, `adaptive:680ns`, `static:20us`, `cycle:31.25us`; the text parses to the same rule.
std::string text_of(const Timeout& timeout);

/// Names of encoders and safety configurations that `name` may be meant for: at most three that
/// begin with it, else the one with the fewest typing slips; empty when none is near.
std::string suggested_encoders(std::string_view name);

}  // namespace biss::cli
