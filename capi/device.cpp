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

// \pre is_possible()
void put(const biss_timing& from, DeviceTiming& to) {
  to.clock_min = hertz(from.clock_min_hz);
  to.clock_max = hertz(from.clock_max_hz);
  to.start_min = picoseconds(from.start_min_ps);
  to.ack_max = picoseconds(from.ack_max_ps);
  to.ack_clocks = static_cast<std::uint16_t>(from.ack_clocks);
  to.timeout.rule = static_cast<TimeoutRule>(from.timeout_rule);
  to.timeout.time = picoseconds(from.timeout_ps);
  const std::uint32_t release = from.release_half_periods;
  if (release != 0) to.timeout.release_half_periods = static_cast<std::uint8_t>(release);
  to.internal_delay_max = picoseconds(from.internal_delay_max_ps);
  to.cycle_min = picoseconds(from.cycle_min_ps);
  to.sampling_min = picoseconds(from.sampling_min_ps);
  to.sampling_typical = picoseconds(from.sampling_typical_ps);
  to.sampling_max = picoseconds(from.sampling_max_ps);
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

biss_crc as_c(const CrcSpec& crc) {
  return {crc.polynomial, crc.start,         crc.width_bits, crc.inverted,
          crc.reversed,   crc.without_flags, crc.with_cds,   crc.of_previous};
}

biss_flag as_c(const FlagField& flag) { return {flag.present, flag.shift, flag.active_high}; }

biss_channel_format as_c(const ChannelFormat& channel) {
  const auto part = [](const Field& field, bool gray, bool lsb) {
    return biss_field{field.bits, field.shift, gray, lsb};
  };
  return {channel.data_bits,
          part(channel.position, channel.position_gray, channel.position_lsb),
          part(channel.multiturn, channel.multiturn_gray, channel.multiturn_lsb),
          part(channel.singleturn, channel.singleturn_gray, channel.singleturn_lsb),
          part(channel.life_counter, false, false),
          as_c(channel.error),
          as_c(channel.warning),
          as_c(channel.crc)};
}

Field from_c(const biss_field& field) { return {field.shift, field.bits}; }

FlagField from_c(const biss_flag& flag) { return {flag.shift, flag.present, flag.active_high}; }

// Member by member, which is the smallest code.
void put(const biss_channel_format& from, ChannelFormat& to) {
  to.data_bits = from.data_bits;
  to.position = from_c(from.position);
  to.multiturn = from_c(from.multiturn);
  to.singleturn = from_c(from.singleturn);
  to.position_gray = from.position.gray;
  to.multiturn_gray = from.multiturn.gray;
  to.singleturn_gray = from.singleturn.gray;
  to.position_lsb = from.position.lsb;
  to.multiturn_lsb = from.multiturn.lsb;
  to.singleturn_lsb = from.singleturn.lsb;
  to.error = from_c(from.error);
  to.warning = from_c(from.warning);
  to.life_counter = from_c(from.life_counter);
  if (from.crc.width_bits != 0) to.crc = crc_from_c(from.crc);
}

// Whether the fields are in the data and do not overlap.
bool is_possible(const ChannelFormat& channel) {
  if (channel.data_bits < 1 || channel.data_bits > max_data_bits) return false;
  std::uint64_t taken = ~low_mask(channel.data_bits);
  for (const Field& field :
       {channel.position, channel.multiturn, channel.singleturn, channel.life_counter,
        channel.error.place(), channel.warning.place()}) {
    if (!field.present()) continue;
    if (field.shift >= max_data_bits || field.bits > max_data_bits - field.shift) return false;
    const std::uint64_t bits = field.placed(~std::uint64_t{0});
    if ((taken & bits) != 0) return false;
    taken |= bits;
  }
  const bool in_parts = channel.multiturn.present() || channel.singleturn.present();
  return !(channel.position.present() && in_parts) &&
         channel.life_counter.bits <= max_life_counter_bits;
}

}  // namespace

biss_format as_c(const FrameFormat& format, const DeviceTiming& timing) {
  biss_format result{};
  result.timing = as_c(timing);
  result.cds0 = format.cds0;
  for (const ChannelFormat& channel : format.channels()) {
    result.channels[result.channel_count++] = as_c(channel);
  }
  return result;
}

CrcSpec crc_from_c(const biss_crc& crc) {
  return {crc.polynomial,
          static_cast<std::uint16_t>(crc.start),
          static_cast<std::uint8_t>(crc.width_bits),
          crc.inverted,
          crc.reversed,
          crc.without_flags,
          crc.with_cds,
          crc.of_previous};
}

bool is_possible(const biss_crc& crc) {
  return crc.width_bits >= min_crc_bits && crc.width_bits <= max_crc_bits &&
         is_full_form(crc.polynomial, crc.width_bits) && (crc.start >> crc.width_bits) == 0;
}

biss_status read(const biss_format* from, Described& to) {
  if (from == nullptr) return BISS_NULL_ARGUMENT;
  if (from->channel_count < 1 || from->channel_count > max_channels) return BISS_BAD_FORMAT;
  to.format.cds0 = from->cds0;
  for (std::uint8_t& k = to.format.channel_count = 0; k < from->channel_count; ++k) {
    const biss_channel_format& channel = from->channels[k];
    if (channel.crc.width_bits != 0 && !is_possible(channel.crc)) return BISS_BAD_FORMAT;
    put(channel, to.format.channel_list[k]);
    if (!is_possible(to.format.channel_list[k])) return BISS_BAD_FORMAT;
  }
  if (!is_possible(from->timing)) return BISS_BAD_TIMING;
  put(from->timing, to.timing);
  return BISS_OK;
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

extern "C" biss_format biss_format_defaults(void) {
  biss_format format{};
  format.timing = biss::capi::as_c(biss::DeviceTiming{});
  return format;
}
