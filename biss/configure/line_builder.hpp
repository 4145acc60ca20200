// What the slaves say, put together: one format and one behaviour in time for the whole line.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/configure/configuration.hpp"
#include "biss/configure/configure_error.hpp"
#include "biss/eds/profile.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss::configure_detail {

/// What an EDS says of the IDs `first` … `first + ids - 1`.
struct LineDevice {
  std::uint8_t first = 0;
  std::uint8_t ids = 1;
  /// Its channels in the order on the line, at most one for each ID.
  FrameFormat format{};
  DeviceTiming timing{};
  std::uint8_t busy_s_clocks = 0;
  ValueSource format_source = ValueSource::eds;
  ValueSource clock_source = ValueSource::eds;
  ValueSource timeout_source = ValueSource::eds;
  ValueSource busy_source = ValueSource::eds;
  ValueSource cycle_source = ValueSource::eds;
};

/// A device of which nothing is known but that it is a BiSS C device.
constexpr DeviceTiming unstated_timing(Hertz clock_max) {
  return {.clock_min = common_clock_min, .clock_max = clock_max};
}

class LineBuilder {
 public:
  /// A slave that has no EDS of its own. An EDS that was told earlier, or is told later, and speaks
  /// of this ID too, wins.
  constexpr void add_profile(std::size_t slave, const SlaveDescription& description,
                             const ProfileOptions& options) {
    Slot& slot = slots_[slave];
    if (slot.source == ValueSource::eds) return;
    const auto channel = profile_channel(description.profile.value_or(0), options);
    slot.known = channel.ok() || channel.error() == ProfileError::no_channel;
    slot.present = channel.ok();
    if (channel.ok()) {
      slot.channel = *channel;
      slot.source = ValueSource::profile;
    } else if (slot.known) {
      slot.source = ValueSource::profile;
    } else if (description.eds_unused) {
      slot.cause = ConfigureError::eds_checksum;
    } else if (channel.error() == ProfileError::none_given) {
      slot.cause = ConfigureError::no_profile;
    } else {
      slot.cause = ConfigureError::unknown_profile;
      slot.profile = channel.error();
    }
  }

  /// \return false: it speaks of IDs that do not exist, or of more channels than IDs
  constexpr bool add_device(const LineDevice& device) {
    const std::size_t end = std::size_t{device.first} + device.ids;
    const std::size_t count = device.format.channel_count;
    if (device.ids == 0 || end > slots_.size() || count > device.ids) return false;
    for (std::size_t i = 0; i < device.ids; ++i) {
      Slot& slot = slots_[device.first + i];
      slot = {.known = true, .present = i < count, .source = ValueSource::eds};
      // The line brings the highest ID first.
      if (slot.present) slot.channel = device.format.channel_list[count - 1 - i];
    }
    format_source_ = std::min(format_source_, device.format_source);
    clock_source_ = std::min(clock_source_, device.clock_source);
    timeout_source_ = std::min(timeout_source_, device.timeout_source);
    busy_source_ = std::min(busy_source_, device.busy_source);
    cycle_source_ = std::min(cycle_source_, device.cycle_source);
    busy_s_clocks_ = std::max(busy_s_clocks_, device.busy_s_clocks);
    merge(device.timing);
    return true;
  }

  /// Fills in format, timing and sources. \pre config.slave_count is known
  constexpr std::optional<ConfigureFault> finish(Configuration& config, Hertz unstated_clock_max) {
    const std::size_t slaves = config.slave_count;
    for (std::size_t k = 0; k < slaves; ++k) {
      const Slot& slot = slots_[k];
      const auto id = static_cast<std::uint8_t>(k);
      if (!slot.known) {
        return ConfigureFault{.cause = slot.cause,
                              .step = ConfigureStep::profile,
                              .slave = id,
                              .profile = slot.profile};
      }
      config.slave_list[k].source = slot.source;
      format_source_ = std::min(format_source_, slot.source);
      if (slot.source == ValueSource::eds) continue;
      clock_source_ = timeout_source_ = busy_source_ = cycle_source_ = ValueSource::defaults;
      busy_s_clocks_ = biss_busy_s_max_clocks;
      merge(unstated_timing(unstated_clock_max));
    }
    for (std::size_t k = slaves; k-- > 0;) {
      const Slot& slot = slots_[k];
      if (slot.present) config.format.channel_list[config.format.channel_count++] = slot.channel;
    }
    if (config.format.channel_count == 0) {
      return ConfigureFault{.cause = ConfigureError::no_channel, .step = ConfigureStep::profile};
    }
    config.timing = timing_.value_or(unstated_timing(unstated_clock_max));
    config.start_delay_clocks = static_cast<std::uint8_t>(busy_s_clocks_ + slaves - 1);
    config.format_source = format_source_;
    config.clock_source = clock_source_;
    config.timeout_source = timeout_source_;
    config.busy_source = busy_source_;
    config.cycle_source = cycle_source_;
    return std::nullopt;
  }

 private:
  struct Slot {
    bool known = false;
    bool present = false;  // the slave sends a channel
    ValueSource source = ValueSource::defaults;
    ChannelFormat channel{};
    ConfigureError cause = ConfigureError::no_profile;
    std::optional<ProfileError> profile{};
  };

  constexpr void merge(const DeviceTiming& other) {
    if (!timing_) {
      timing_ = other;
      return;
    }
    DeviceTiming& all = *timing_;
    all.clock_min = std::max(all.clock_min, other.clock_min);
    all.clock_max = std::min(all.clock_max, other.clock_max);
    all.start_min = std::min(all.start_min, other.start_min);
    all.ack_max = std::max(all.ack_max, other.ack_max);
    // A clock that one device always takes may be two where another is slower.
    all.ack_clocks = all.ack_clocks == other.ack_clocks ? all.ack_clocks : std::uint16_t{0};
    if (all.timeout.rule == other.timeout.rule) {
      all.timeout.time = std::max(all.timeout.time, other.timeout.time);
    } else {
      all.timeout = {};
    }
    all.internal_delay_max += other.internal_delay_max;
    all.cycle_min = std::max(all.cycle_min, other.cycle_min);
  }

  std::array<Slot, control_max_slaves> slots_{};
  std::optional<DeviceTiming> timing_{};
  std::uint8_t busy_s_clocks_ = 0;
  ValueSource format_source_ = ValueSource::eds;
  ValueSource clock_source_ = ValueSource::eds;
  ValueSource timeout_source_ = ValueSource::eds;
  ValueSource busy_source_ = ValueSource::eds;
  ValueSource cycle_source_ = ValueSource::eds;
};

}  // namespace biss::configure_detail
