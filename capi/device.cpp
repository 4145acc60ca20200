#include "capi/device.hpp"

#include <array>
#include <bit>
#include <cstddef>
#include <utility>

namespace biss::capi {

static_assert(BISS_MAX_CHANNELS == max_channels);
static_assert(BISS_TIMEOUT_ADAPTIVE == static_cast<int>(TimeoutRule::adaptive) &&
              BISS_TIMEOUT_FIXED == static_cast<int>(TimeoutRule::fixed) &&
              BISS_TIMEOUT_CYCLE == static_cast<int>(TimeoutRule::cycle));

namespace {

bool is_possible(const biss_timing& timing) {
  if (!are_durations({timing.start_min_ps, timing.ack_max_ps, timing.timeout.time_ps,
                      timing.timeout.shortest_ps, timing.internal_delay_max_ps, timing.cycle_min_ps,
                      timing.sampling_min_ps, timing.sampling_typical_ps,
                      timing.sampling_max_ps})) {
    return false;
  }
  const unsigned release = timing.timeout.release_half_periods;
  return (release == 0 || release >= biss_release_half_periods_min) &&
         timing.timeout.rule <= BISS_TIMEOUT_CYCLE && timing.ack_clocks <= biss_ack_max_clocks &&
         timing.clock_min_hz <= timing.clock_max_hz &&
         timing.sampling_min_ps <= timing.sampling_typical_ps &&
         timing.sampling_typical_ps <= timing.sampling_max_ps;
}

// The same members in the same order, in C and in C++.
static_assert(sizeof(biss_timing) == sizeof(DeviceTiming) &&
              offsetof(biss_timing, timeout) == offsetof(DeviceTiming, timeout) &&
              sizeof(biss_channel_format) == sizeof(ChannelFormat) &&
              sizeof(biss_crc) == sizeof(CrcSpec) &&
              offsetof(biss_channel_format, error) == offsetof(ChannelFormat, error) &&
              offsetof(biss_channel_format, crc) == offsetof(ChannelFormat, crc));

// Whether the fields are in the data and do not overlap.
bool is_possible(const ChannelFormat& channel) {
  if (channel.data_bits < 1 || channel.data_bits > max_data_bits) return false;
  std::array<bool, max_data_bits> taken{};
  for (const Field& field :
       {channel.position, channel.multiturn, channel.singleturn, channel.life_counter,
        channel.error.place(), channel.warning.place()}) {
    for (unsigned bit = field.shift; bit < unsigned{field.shift} + field.bits; ++bit) {
      if (bit >= channel.data_bits || std::exchange(taken[bit], true)) return false;
    }
  }
  const bool in_parts = channel.multiturn.present() || channel.singleturn.present();
  return !(channel.position.present() && in_parts) &&
         channel.life_counter.bits <= max_life_counter_bits &&
         (!channel.crc.present() || is_checksum(channel.crc));
}

}  // namespace

biss_format as_c(const FrameFormat& format, const DeviceTiming& timing) {
  biss_format result{};
  result.timing = std::bit_cast<biss_timing>(timing);
  result.cds0 = format.cds0;
  for (const ChannelFormat& channel : format.channels()) {
    result.channels[result.channel_count++] = std::bit_cast<biss_channel_format>(channel);
  }
  return result;
}

bool is_checksum(const CrcSpec& crc) {
  return crc.width_bits >= min_crc_bits && crc.width_bits <= max_crc_bits &&
         is_full_form(crc.polynomial, crc.width_bits) && (crc.start >> crc.width_bits) == 0;
}

biss_status read(const biss_format* from, Described& to) {
  if (from == nullptr) return BISS_NULL_ARGUMENT;
  if (from->channel_count < 1 || from->channel_count > max_channels) return BISS_BAD_FORMAT;
  to.format.cds0 = from->cds0;
  for (std::uint8_t& k = to.format.channel_count = 0; k < from->channel_count; ++k) {
    to.format.channel_list[k] = std::bit_cast<ChannelFormat>(from->channels[k]);
    if (!is_possible(to.format.channel_list[k])) return BISS_BAD_FORMAT;
  }
  if (!is_possible(from->timing)) return BISS_BAD_TIMING;
  to.timing = std::bit_cast<DeviceTiming>(from->timing);
  std::uint8_t& release = to.timing.timeout.release_half_periods;
  if (release == 0) release = biss_release_half_periods;
  return BISS_OK;
}

std::uint32_t put_channels(const Frame& frame, biss_channel* channels) {
  for (const Channel& channel : frame.channels())
    *channels++ = std::bit_cast<biss_channel>(channel);
  return frame.channel_count;
}

extern "C" biss_format biss_format_defaults(void) {
  biss_format format{};
  format.timing = std::bit_cast<biss_timing>(DeviceTiming{});
  return format;
}

}  // namespace biss::capi
