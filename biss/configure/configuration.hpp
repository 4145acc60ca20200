// What a configuration finds out.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/control/control_frame.hpp"
#include "biss/control/register_map.hpp"
#include "biss/frame/format.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

/// Clocks that every slave takes, and the cycle that none needs to be longer (D2, table of
/// characteristics; PROTOCOL 1.3, rows 2 and 12).
inline constexpr Hertz common_clock_min = kilohertz(250);
inline constexpr Hertz common_clock_max = megahertz(1);
inline constexpr Picoseconds common_cycle = microseconds(250);

/// Where a value comes from, the weakest first. Of several slaves the weakest counts.
enum class ValueSource : std::uint8_t {
  defaults,    ///< nobody said: what every BiSS C device keeps
  hypothesis,  ///< the electronic data sheet, in a unit that no source confirms
  profile,     ///< the profile identifier
  eds,         ///< the electronic data sheet
};

inline constexpr std::size_t value_source_count = 4;

/// The name users see.
constexpr std::string_view name_of(ValueSource source) {
  constexpr std::array<std::string_view, value_source_count> names{"default", "hypothesis",
                                                                   "profile", "eds"};
  return names[static_cast<std::size_t>(source)];
}

/// What one slave says of itself; nothing: it does not.
struct SlaveDescription {
  std::optional<DeviceIdentity> identity{};
  std::optional<std::uint32_t> serial{};
  /// Registers 0x42 (upper byte) and 0x43; 0: no profile.
  std::optional<std::uint16_t> profile{};
  /// Register 0x41.
  std::uint8_t eds_bank = 0;
  /// Of its channel; `eds` also where another slave of the device holds the EDS.
  ValueSource source = ValueSource::defaults;
  /// The EDS is there and was left aside, because its checksum is wrong or it could not be read.
  bool eds_unused = false;
};

/// What configures master, decoder and model of everything on the line.
struct Configuration {
  /// The channels in the order on the line: highest ID first.
  FrameFormat format{};
  /// Of the line as a whole: what its weakest device keeps.
  DeviceTiming timing{};
  /// START may come so many clocks later than the devices are ready: their "busy_s", and one for
  /// each ID behind the first.
  std::uint8_t start_delay_clocks = 0;
  ValueSource format_source = ValueSource::eds;
  ValueSource clock_source = ValueSource::eds;
  ValueSource timeout_source = ValueSource::eds;
  ValueSource busy_source = ValueSource::eds;
  ValueSource cycle_source = ValueSource::eds;
  /// By ID.
  std::array<SlaveDescription, control_max_slaves> slave_list{};
  std::uint8_t slave_count = 0;
  /// The channels were deactivated meanwhile, and at least one slave obeyed.
  bool channels_were_switched = false;

  constexpr std::span<const SlaveDescription> slaves() const {
    return std::span<const SlaveDescription>(slave_list).first(slave_count);
  }
  /// A master for frames of this format. Bounds are those of a device that shares a START among its
  /// IDs, as well as of one device each.
  constexpr MasterSetup master_setup(Picoseconds period) const {
    return {.period = period, .timing = timing, .busy_s_clocks = start_delay_clocks};
  }
};

}  // namespace biss
