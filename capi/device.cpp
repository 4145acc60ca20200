#include "capi/device.hpp"

namespace biss::capi {

static_assert(BISS_MAX_CHANNELS == max_channels);
static_assert(BISS_TIMEOUT_ADAPTIVE == static_cast<int>(TimeoutRule::adaptive) &&
              BISS_TIMEOUT_FIXED == static_cast<int>(TimeoutRule::fixed) &&
              BISS_TIMEOUT_CYCLE == static_cast<int>(TimeoutRule::cycle));

biss_timing as_c(const DeviceTiming& timing) {
  return {.clock_min_hz = timing.clock_min.count,
          .clock_max_hz = timing.clock_max.count,
          .start_min_ps = timing.start_min.count,
          .ack_max_ps = timing.ack_max.count,
          .ack_clocks = timing.ack_clocks,
          .timeout_rule = static_cast<std::uint32_t>(timing.timeout.rule),
          .timeout_ps = timing.timeout.time.count,
          .release_half_periods = timing.timeout.release_half_periods,
          .internal_delay_max_ps = timing.internal_delay_max.count,
          .cycle_min_ps = timing.cycle_min.count,
          .sampling_min_ps = timing.sampling_min.count,
          .sampling_typical_ps = timing.sampling_typical.count,
          .sampling_max_ps = timing.sampling_max.count};
}

namespace {

DeviceTiming from_c(const biss_timing& timing) {
  const std::uint32_t release = timing.release_half_periods;
  return {
      .clock_min = hertz(timing.clock_min_hz),
      .clock_max = hertz(timing.clock_max_hz),
      .start_min = picoseconds(timing.start_min_ps),
      .ack_max = picoseconds(timing.ack_max_ps),
      .ack_clocks = static_cast<std::uint16_t>(timing.ack_clocks),
      .timeout = {static_cast<TimeoutRule>(timing.timeout_rule), picoseconds(timing.timeout_ps),
                  release != 0 ? static_cast<std::uint8_t>(release) : biss_release_half_periods},
      .internal_delay_max = picoseconds(timing.internal_delay_max_ps),
      .cycle_min = picoseconds(timing.cycle_min_ps),
      .sampling_min = picoseconds(timing.sampling_min_ps),
      .sampling_typical = picoseconds(timing.sampling_typical_ps),
      .sampling_max = picoseconds(timing.sampling_max_ps)};
}

bool is_possible(const biss_timing& timing) {
  if (!are_durations({timing.start_min_ps, timing.ack_max_ps, timing.timeout_ps,
                      timing.internal_delay_max_ps, timing.cycle_min_ps, timing.sampling_min_ps,
                      timing.sampling_typical_ps, timing.sampling_max_ps})) {
    return false;
  }
  const std::uint32_t release = timing.release_half_periods;
  if (release != 0 && (release < biss_release_half_periods_min || release > UINT8_MAX)) {
    return false;
  }
  return timing.timeout_rule <= BISS_TIMEOUT_CYCLE && timing.ack_clocks <= biss_ack_max_clocks &&
         timing.clock_min_hz <= timing.clock_max_hz &&
         timing.sampling_min_ps <= timing.sampling_typical_ps &&
         timing.sampling_typical_ps <= timing.sampling_max_ps;
}

}  // namespace

std::optional<Device> find_device(const char* format) {
  const auto device = read_device(format);
  if (!device.ok()) return std::nullopt;
  return *device;
}

bool override_timing(const biss_timing* timing, Device& device) {
  if (timing == nullptr) return true;
  if (!is_possible(*timing)) return false;
  device.timing = from_c(*timing);
  return true;
}

biss_channel as_c(const Channel& channel) {
  return {channel.position, channel.life_counter, channel.nE, channel.nW};
}

std::uint32_t put_channels(const Frame& frame, biss_channel* channels) {
  for (const Channel& channel : frame.channels()) *channels++ = as_c(channel);
  return frame.channel_count;
}

// One for each cause, in the order of FrameError.
static_assert(BISS_CAUSE_NO_RESPONSE == 1 + static_cast<int>(FrameError::no_response));
static_assert(BISS_CAUSE_STOP_BIT == 1 + static_cast<int>(FrameError::stop_bit));
static_assert(BISS_CAUSE_STOP_BIT == frame_error_count);

biss_cause cause_of(const FrameFault& fault) {
  return static_cast<biss_cause>(1 + static_cast<int>(fault.cause));
}

}  // namespace biss::capi
