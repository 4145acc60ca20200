// Where a configuration stands, and why there is none.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/control/control_error.hpp"
#include "biss/eds/profile.hpp"
#include "biss/eds/remark.hpp"

namespace biss {

/// What a Configurator is at; in this order, from `identity` to `restore_bank` once for each slave.
enum class ConfigureStep : std::uint8_t {
  channels_off,   ///< broadcast: deactivate the data channels
  init,           ///< INIT, with a rest before and behind it
  identity,       ///< registers 0x78 to 0x7F, and how many slaves there are
  profile,        ///< registers 0x42 and 0x43
  serial,         ///< registers 0x44 to 0x47
  find_eds,       ///< register 0x41
  select_bank,    ///< register 0x40: read, then written
  read_common,    ///< the EDS' common part
  read_channels,  ///< the EDS' part of each channel
  restore_bank,   ///< register 0x40 as it was
  channels_on,    ///< addressed: activate the data channels
  rest,           ///< zeros until every slave waits for a start bit
  done,
};

inline constexpr std::size_t configure_step_count = 13;

/// The name users see, the same as the enumerator's.
constexpr std::string_view name_of(ConfigureStep step) {
  constexpr std::array<std::string_view, configure_step_count> names{
      "channels_off", "init",        "identity",    "profile",       "serial",
      "find_eds",     "select_bank", "read_common", "read_channels", "restore_bank",
      "channels_on",  "rest",        "done"};
  return names[static_cast<std::size_t>(step)];
}

/// The one cause why there is no configuration.
enum class ConfigureError : std::uint8_t {
  no_encoder,       ///< no request brought a CDS: nothing connected, no power, SLO stuck
  no_control,       ///< CDS stays 0, no slave takes an ID: a unidirectional encoder, or its control
                    ///< communication is deactivated
  line_lost,        ///< slaves were there, and then frames or slaves were missing
  too_many_slaves,  ///< more than eight
  control_failed,   ///< the control communication failed otherwise: `control` says how
  no_profile,       ///< a slave with neither an EDS nor a profile identifier
  unknown_profile,  ///< an identifier that gives no format: `profile` says why
  eds_checksum,     ///< as no_profile; there is an EDS, but its checksum is wrong
  eds_contradiction,  ///< an EDS that no frame can be made of: `eds` says why; nothing: it speaks
                      ///< of slaves that are not there, or of more channels than slaves
  no_channel,         ///< not one slave has a data channel
  too_many_channels,  ///< more than eight
  channels_stay_off,  ///< they were deactivated, and could not be activated again
  too_many_requests,  ///< ConfigureOptions::max_requests
};

inline constexpr std::size_t configure_error_count = 13;

/// The name users see, the same as the enumerator's.
constexpr std::string_view name_of(ConfigureError error) {
  constexpr std::array<std::string_view, configure_error_count> names{
      "no_encoder",        "no_control", "line_lost",         "too_many_slaves",
      "control_failed",    "no_profile", "unknown_profile",   "eds_checksum",
      "eds_contradiction", "no_channel", "too_many_channels", "channels_stay_off",
      "too_many_requests"};
  return names[static_cast<std::size_t>(error)];
}

/// A cause, and where it was met.
struct ConfigureFault {
  ConfigureError cause{};
  ConfigureStep step{};
  /// ID of the slave that was asked; 0 where all are meant.
  std::uint8_t slave = 0;
  /// How the access ended, where one did not go well.
  std::optional<ControlError> control{};
  std::optional<ProfileError> profile{};
  std::optional<EdsDeviceCause> eds{};

  constexpr bool operator==(const ConfigureFault&) const = default;
};

/// What a configuration that failed may have left another way than it was found.
struct LeftBehind {
  /// Bit k: BSEL of the slave with ID k.
  std::uint8_t banks = 0;
  /// The channels were deactivated, as far as slaves obey that, and nobody confirmed the
  /// activation.
  bool channels_off = false;

  constexpr bool operator==(const LeftBehind&) const = default;
};

}  // namespace biss
