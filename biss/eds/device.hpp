// From a data sheet to what a master and a decoder need: FrameFormat and DeviceTiming.
//
//   const auto device = describe_device(image, {}, [](const biss::EdsRemark& said) { … });
//   if (device.ok()) use(device->format, timing_at(*device, clock));
//
// What devices hold is often wrong. So everything is used that can be, whatever disagrees or was
// replaced is said, and single fields can be overridden. Nothing is allocated.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/eds/device_channel.hpp"
#include "biss/eds/reader.hpp"
#include "biss/eds/remark.hpp"
#include "biss/eds/scale.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"

namespace biss {

struct EdsDevice {
  FrameFormat format{};
  /// Without BUSY_S, which counts clocks: timing_at().
  DeviceTiming timing{};
  std::uint8_t busy_s_clocks = 0;
  /// IDs the device takes; 0: not known.
  std::uint8_t slaves = 0;
  /// From power-on until control communication (a hypothesis) and until the last of the positions.
  std::optional<Picoseconds> control_ready{};
  std::optional<Picoseconds> position_ready{};
};

/// The device's timing at one clock: BUSY_S delays START beyond the processing time; both together
/// take 40 us at most (D2). \pre clock is not 0 Hz
constexpr DeviceTiming timing_at(const EdsDevice& device, Hertz clock) {
  DeviceTiming timing = device.timing;
  const Picoseconds busy_s = std::int64_t{device.busy_s_clocks} * period_of(clock);
  timing.ack_max = std::min(timing.ack_max + busy_s, biss_busy_max);
  return timing;
}

namespace eds_detail {

template <class Sink>
class TimingReader {
 public:
  constexpr TimingReader(const CommonPart& part, const EdsDeviceOptions& options, Sink& sink)
      : part_(part), options_(options), sink_(sink) {}

  constexpr void fill(EdsDevice& device) const {
    DeviceTiming& timing = device.timing;
    set_clock(timing);
    if (part_.busy_s <= biss_busy_s_max_clocks) {
      device.busy_s_clocks = part_.busy_s;
    } else {
      say(EdsRemarkKind::not_usable, "BUSY_S", part_.busy_s, 0);
      device.busy_s_clocks = biss_busy_s_max_clocks;
    }
    if (const auto busy = time("TBUSY_MAX", part_.tbusy_max, biss_busy_max)) timing.ack_max = *busy;
    set_timeout(timing.timeout);
    // A longer cycle is safe, so all ones are a time here.
    if (part_.tcyc != 0 && options_.use_hypotheses) {
      const EdsTime cycle = eds_time("TCYC", part_.tcyc);
      say(EdsRemarkKind::hypothesis, "TCYC", cycle.raw, cycle.raw);
      timing.cycle_min = cycle.time;
    }
    if (part_.pon_dly != 0 && part_.pon_dly != 0xFFFF && options_.use_hypotheses) {
      const EdsTime delay = eds_time("PON_DLY", part_.pon_dly);
      say(EdsRemarkKind::hypothesis, "PON_DLY", delay.raw, delay.raw);
      device.control_ready = delay.time;
    }
  }

 private:
  constexpr void say(EdsRemarkKind kind, std::string_view symbol, std::uint32_t stored,
                     std::uint32_t used) const {
    sink_(EdsRemark{EdsPart::common, 0, symbol, kind, stored, used});
  }

  constexpr void set_clock(DeviceTiming& timing) const {
    if (part_.tma == 0) {
      say(EdsRemarkKind::not_given, "TMA", part_.tma, 0);
      return;
    }
    const Hertz clock = rate_of(eds_time("TMA", part_.tma).time);
    if (clock > biss_clock_max) say(EdsRemarkKind::not_usable, "TMA", part_.tma, 0);
    timing.clock_max = std::min(clock, biss_clock_max);
  }

  // A time that is given, no longer than BiSS C allows, and may be used.
  constexpr std::optional<Picoseconds> time(std::string_view symbol, std::uint8_t raw,
                                            Picoseconds longest) const {
    if (!options_.use_hypotheses) return std::nullopt;
    if (raw == 0 || raw == 0xFF) {
      say(EdsRemarkKind::not_given, symbol, raw, 0);
      return std::nullopt;
    }
    const EdsTime value = eds_time(symbol, raw);
    if (value.time > longest) {
      say(EdsRemarkKind::not_usable, symbol, raw, 0);
      return std::nullopt;
    }
    say(EdsRemarkKind::hypothesis, symbol, raw, raw);
    return value.time;
  }

  // A device that states its sampling clock has the adaptive timeout, at most 3 of these clocks
  // above 1.5 periods (D2); else the short one, else the static one.
  constexpr void set_timeout(Timeout& timeout) const {
    const auto given = [](std::uint8_t raw) { return raw != 0 && raw != 0xFF; };
    if (given(part_.tclk_max)) {
      const auto clock = time("TCLK_MAX", part_.tclk_max, biss_static_timeout_max);
      if (!clock) return;
      timeout.rule = TimeoutRule::adaptive;
      timeout.time = 3 * *clock;
      return;
    }
    const bool is_short = given(part_.tos_max);
    const auto fixed = is_short ? time("TOS_MAX", part_.tos_max, biss_static_timeout_max)
                                : time("TO_MAX", part_.to_max, biss_static_timeout_max);
    if (!fixed) return;
    timeout.rule = TimeoutRule::fixed;
    timeout.time = *fixed;
  }

  const CommonPart& part_;
  const EdsDeviceOptions& options_;
  Sink& sink_;
};

constexpr void set_position_ready(const EdsReader& reader, std::size_t channel, EdsDevice& device) {
  const EdsImage& image = reader.image();
  if (image.profiles[channel] == nullptr || profile_part(image, channel) != EdsPart::bp3) return;
  const std::uint8_t delay = reader.bp3(channel).pon_pdl;
  if (delay == 0 || delay == 0xFF) return;
  device.position_ready =
      std::max(device.position_ready.value_or(Picoseconds{}), milliseconds(delay));
}

}  // namespace eds_detail

/// The device that a data sheet describes, as far as it was read, with `overrides` made first.
/// What is set by hand is believed before the registers, these before the profile's part, and that
/// before the common part. Times that are not given stay the widest that BiSS C allows. Parts of
/// BP1 and BP3S stay raw; the CRC at BP3's addresses is taken from them as a hypothesis.
template <EdsRemarkSink Sink>
constexpr Result<EdsDevice, EdsDeviceError> describe_device(const EdsImage& image,
                                                            std::span<const EdsOverride> overrides,
                                                            Sink&& sink,
                                                            const EdsDeviceOptions& options = {}) {
  using PlainSink = std::remove_reference_t<Sink>;
  const eds_detail::EdsReader reader(image, overrides);
  const auto announced = reader.announce(sink);
  if (!announced.ok()) return failure(announced.error());
  EdsDevice device;
  std::size_t channels = channel_count(image);
  if (image.common != nullptr) {
    const CommonPart common = reader.common();
    channels = std::min<std::size_t>(common.dc_num, max_channels);
    device.slaves = common.sl_num;
    eds_detail::TimingReader<PlainSink>(common, options, sink).fill(device);
  }
  if (channels == 0) return failure(EdsDeviceError{EdsDeviceCause::no_channel, 0});
  if (channels > 1) {
    const auto count = static_cast<std::uint32_t>(channels);
    sink(EdsRemark{EdsPart::common, 0, "DC_NUM", EdsRemarkKind::order, count, count});
  }
  for (std::size_t i = 0; i < channels; ++i) {
    const auto channel = eds_detail::ChannelReader<PlainSink>(reader, i, options, sink).run();
    if (!channel.ok()) return failure(channel.error());
    device.format.channel_list[options.highest_channel_first ? channels - 1 - i : i] = *channel;
    eds_detail::set_position_ready(reader, i, device);
  }
  device.format.channel_count = static_cast<std::uint8_t>(channels);
  return device;
}

}  // namespace biss
