// The options, the results and the causes of failure of automatic configuration.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/register_map.hpp"
#include "biss/control/session.hpp"
#include "biss/eds/check.hpp"
#include "biss/eds/device.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

// ---- Steps and errors of a configuration

/// The step of a Configurator; in this order, from `identity` to `find_eds` once for each slave,
/// then from `select_bank` to `restore_bank` once for each slave that holds an EDS.
enum class ConfigureStep : std::uint8_t {
  channels_off,   ///< broadcast: deactivate the data channels
  init,           ///< INIT, with idle time before and after it
  identity,       ///< registers 0x78 to 0x7F, and how many slaves there are
  profile,        ///< registers 0x42 and 0x43
  serial,         ///< registers 0x44 to 0x47
  find_eds,       ///< register 0x41
  select_bank,    ///< register 0x40: read, then written
  read_common,    ///< the EDS' common part
  read_channels,  ///< the EDS' part of each channel
  restore_bank,   ///< register 0x40 restored
  channels_on,    ///< addressed: activate the data channels
  rest,           ///< zeros until every slave waits for a start bit
  done,
};

inline constexpr std::size_t configure_step_count = 13;

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(ConfigureStep step) {
  constexpr std::array<std::string_view, configure_step_count> names{
      "channels_off", "init",        "identity",    "profile",       "serial",
      "find_eds",     "select_bank", "read_common", "read_channels", "restore_bank",
      "channels_on",  "rest",        "done"};
  return names[static_cast<std::size_t>(step)];
}

/// Why there is no configuration.
enum class ConfigureError : std::uint8_t {
  no_encoder,       ///< no request brought a CDS: nothing connected, no power, SLO stuck
  no_control,       ///< CDS stays 0, no slave takes an ID: a unidirectional encoder, or its control
                    ///< communication is deactivated
  line_lost,        ///< slaves answered, and later frames or slaves were missing
  too_many_slaves,  ///< more than eight
  control_failed,   ///< the control communication failed otherwise: `control` is the cause
  no_profile,       ///< a slave with neither an EDS nor a profile identifier
  unknown_profile,  ///< an identifier that gives no format: `profile` is the cause
  eds_checksum,     ///< as no_profile; there is an EDS, but its checksum is wrong
  eds_unreadable,  ///< as no_profile; there is an EDS, and an access to it failed: `control` is the
                   ///< cause; without it, the maker uses BSEL for something else
  eds_contradiction,  ///< an EDS that describes no frame: `eds` is the cause; or one that contradicts
  ///< itself or the registers: `problem` and `field` are the place; `field` alone: the EDS names
  ///< slaves that do not exist, or more channels than slaves
  no_channel,         ///< no slave has a data channel
  too_many_channels,  ///< more than eight
  channels_stay_off,  ///< they were deactivated and could not be activated again
  too_many_requests,  ///< more than ConfigureOptions::max_requests
};

inline constexpr std::size_t configure_error_count = 14;

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(ConfigureError error) {
  constexpr std::array<std::string_view, configure_error_count> names{
      "no_encoder",        "no_control",        "line_lost",       "too_many_slaves",
      "control_failed",    "no_profile",        "unknown_profile", "eds_checksum",
      "eds_unreadable",    "eds_contradiction", "no_channel",      "too_many_channels",
      "channels_stay_off", "too_many_requests"};
  return names[static_cast<std::size_t>(error)];
}

/// A cause, and the step in which it occurred.
struct ConfigureFault {
  ConfigureError cause{};
  ConfigureStep step{};
  /// The ID of the slave concerned; 0 if all slaves are concerned.
  std::uint8_t slave = 0;
  /// The cause of the failed access, if an access failed.
  std::optional<ControlError> control{};
  std::optional<ProfileError> profile{};
  std::optional<EdsDeviceCause> eds{};
  std::optional<EdsProblem> problem{};
  /// The field of the data sheet, as check_eds() names it; static text.
  std::string_view field{};

  constexpr bool operator==(const ConfigureFault&) const = default;
};

/// The changes that a failed configuration may have left in the device.
struct Unrestored {
  /// Bit k: BSEL of the slave with ID k.
  std::uint8_t banks = 0;
  /// The channels were deactivated, in slaves that obey, and no slave confirmed the activation.
  bool channels_off = false;

  constexpr bool operator==(const Unrestored&) const = default;
};

/// The clocks that every slave accepts, and the cycle time that suffices for every slave (D2, table
/// of characteristics; PROTOCOL 1.3, rows 2 and 12).
inline constexpr Hertz common_clock_min = kilohertz(250);
inline constexpr Hertz common_clock_max = megahertz(1);
inline constexpr Picoseconds common_cycle = microseconds(250);

/// The source of a value, the weakest first. If slaves have different sources, the weakest one
/// counts.
enum class ValueSource : std::uint8_t {
  defaults,    ///< no source: the limits of every BiSS C device
  hypothesis,  ///< the electronic data sheet, in a unit that no source confirms
  profile,     ///< the profile identifier
  eds,         ///< the electronic data sheet
};

/// The name users see.
constexpr std::string_view name_of(ValueSource source) {
  constexpr std::string_view names[] = {"default", "hypothesis", "profile", "eds"};
  return names[static_cast<std::size_t>(source)];
}

/// The description of one slave from its own registers; a value is empty if the slave does not have
/// it.
struct SlaveDescription {
  std::optional<DeviceIdentity> identity{};
  std::optional<std::uint32_t> serial{};
  /// Registers 0x42 (upper byte) and 0x43; 0: no profile.
  std::optional<std::uint16_t> profile{};
  /// Register 0x41.
  std::uint8_t eds_bank = 0;
  /// The source of its channel; `eds` also if another slave of the device holds the EDS.
  ValueSource source = ValueSource::defaults;
  /// The EDS is present but unused: its checksum is wrong or it could not be read.
  bool eds_unused = false;
  /// How many findings check_eds() has about the EDS that the slave holds; none is a contradiction.
  std::uint8_t eds_findings = 0;
};

/// The configuration of master, decoder and model for everything on the line.
struct Configuration {
  /// The channels in the order on the line: highest ID first.
  FrameFormat format{};
  /// The timing of the whole line: the limits of its weakest device.
  DeviceTiming timing{};
  /// START may be this number of clocks later than the moment when the devices are ready: their
  /// "busy_s", and one clock for each ID after the first.
  std::uint8_t start_delay_clocks = 0;
  ValueSource format_source = ValueSource::eds;
  ValueSource clock_source = ValueSource::eds;
  ValueSource timeout_source = ValueSource::eds;
  ValueSource busy_source = ValueSource::eds;
  ValueSource cycle_source = ValueSource::eds;
  /// By ID.
  std::array<SlaveDescription, control_max_slaves> slave_list{};
  std::uint8_t slave_count = 0;
  /// The channels were deactivated during the configuration, and at least one slave obeyed.
  bool channels_were_switched = false;

  constexpr std::span<const SlaveDescription> slaves() const {
    return std::span<const SlaveDescription>(slave_list).first(slave_count);
  }
  /// The setup of a master for frames of this format. The bounds hold for a device that shares one
  /// START among its IDs as well as for one device per ID.
  constexpr MasterSetup master_setup(Picoseconds period) const {
    return {.period = period, .timing = timing, .busy_s_clocks = start_delay_clocks};
  }
};

// ---- Options and requests

/// A function that takes each finding about the EDS of a slave, as soon as the EDS was read.
struct EdsFindingTaker {
  void (*take)(void* user, std::uint8_t slave, const EdsFinding& finding) = nullptr;
  void* user = nullptr;
};

struct ConfigureOptions {
  /// Deactivates the channels during the configuration, which makes each request short. Slaves need
  /// not obey.
  bool switch_channels = true;
  /// From one request's CDS to the next request. A shorter time is at the caller's risk.
  Picoseconds cycle = common_cycle;
  /// The options of each access, with its number of retries.
  ControlOptions control{.retries = 3};
  /// A chain of eight with all data sheets needs about 80 000 requests, 20 s.
  std::uint32_t max_requests = 200'000;
  /// Takes every finding of check_eds(), contradictions included. Null: findings are only counted.
  EdsFindingTaker findings{};
};

/// The next request to make.
struct ConfigureRequest {
  RequestKind kind = RequestKind::reduced;
  /// CDM of this request, unless answer() returns another value.
  bool cdm = false;
  /// The earliest time of the request.
  Picoseconds at{std::numeric_limits<std::int64_t>::min()};
};

}  // namespace biss
