// biss_codec, frames and checksums.
#include "capi/frame.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"

namespace biss::capi {

namespace {

static_assert(BISS_FRAME_BITS_MAX == max_frame_bits);
static_assert(BISS_FRAME_BYTES_MAX == (max_frame_bits + 7U) / 8U);

bool is_range(std::uint32_t least, std::uint32_t most, std::uint32_t limit) {
  return least >= 1 && least <= most && most <= limit;
}

bool is_possible(const biss_bounds& bounds) {
  constexpr FrameBounds widest;
  return is_range(bounds.lead_min_clocks, bounds.lead_max_clocks, widest.lead_max_clocks) &&
         is_range(bounds.ack_min_clocks, bounds.ack_max_clocks, widest.ack_max_clocks) &&
         bounds.late_max_clocks <= widest.lead_max_clocks;
}

// \pre count and clocks are in range
Frame from_c(const biss_frame& frame) {
  Frame result;
  result.channel_count = static_cast<std::uint8_t>(frame.channel_count);
  for (std::size_t k = 0; k < frame.channel_count; ++k) {
    const biss_channel& channel = frame.channels[k];
    result.channel_list[k] = {channel.position, channel.life_counter, channel.nE, channel.nW};
  }
  result.cds = frame.cds;
  result.lead_clocks = static_cast<std::uint16_t>(frame.lead_clocks);
  result.ack_clocks = static_cast<std::uint16_t>(frame.ack_clocks);
  return result;
}

biss_status status_of(EncodeError error) {
  switch (error) {
    case EncodeError::channel_count:
      return BISS_CHANNEL_COUNT;
    case EncodeError::position_too_large:
    case EncodeError::life_counter_too_large:
      return BISS_VALUE_RANGE;
    case EncodeError::ack_range:
    case EncodeError::lead_range:
      break;
    case EncodeError::needs_previous:
      return BISS_BAD_FORMAT;
  }
  return BISS_CLOCK_RANGE;
}

}  // namespace

FrameBounds bounds_from_c(const biss_bounds& bounds) {
  return {.lead_min_clocks = static_cast<std::uint16_t>(bounds.lead_min_clocks),
          .lead_max_clocks = static_cast<std::uint16_t>(bounds.lead_max_clocks),
          .ack_min_clocks = static_cast<std::uint16_t>(bounds.ack_min_clocks),
          .ack_max_clocks = static_cast<std::uint16_t>(bounds.ack_max_clocks),
          .late_max_clocks = static_cast<std::uint16_t>(bounds.late_max_clocks)};
}

biss_bounds as_c(const FrameBounds& bounds) {
  return {bounds.lead_min_clocks, bounds.lead_max_clocks, bounds.ack_min_clocks,
          bounds.ack_max_clocks, bounds.late_max_clocks};
}

biss_frame as_c(const Result<Frame, FrameFault>& from) {
  biss_frame frame{};
  if (!from.ok()) {
    frame.cause = cause_of(from.error());
    frame.cause_channel = from.error().channel;
    return frame;
  }
  frame.channel_count = put_channels(*from, frame.channels);
  frame.cds = from->cds;
  frame.stop_seen = from->stop_seen;
  frame.lead_clocks = from->lead_clocks;
  frame.ack_clocks = from->ack_clocks;
  return frame;
}

}  // namespace biss::capi

using namespace biss::capi;
using Codec = biss::FrameCodec<>;

extern "C" {

biss_status biss_codec_init(biss_codec* codec, const biss_format* format) {
  if (const auto wrong = begin_init(codec)) return wrong;
  Described device;
  if (const auto wrong = read(format, device)) return wrong;
  return make<Codec>(codec, device.format);
}

bool biss_frame_trusted(const biss_frame* frame) {
  if (frame == nullptr || frame->cause != BISS_CAUSE_OK) return false;
  if (frame->no_error_flag || frame->unchecked) return false;
  if (frame->channel_count == 0 || frame->channel_count > BISS_MAX_CHANNELS) return false;
  for (std::size_t k = 0; k < frame->channel_count; ++k) {
    if (!frame->channels[k].nE) return false;
  }
  return true;
}

biss_bounds biss_bounds_defaults(void) { return as_c(biss::FrameBounds{}); }

biss_status biss_frame_decode(const biss_codec* codec, const uint8_t* bytes, size_t byte_count,
                              size_t first_bit, size_t bit_count, const biss_bounds* bounds,
                              biss_frame* frame) {
  if (const auto wrong = check_call(codec, frame, given(bytes, byte_count))) return wrong;
  if (bounds != nullptr && !is_possible(*bounds)) return BISS_BAD_SETUP;
  const Codec& prepared = thing<Codec>(codec);
  if (prepared.format().needs_previous()) return BISS_BAD_FORMAT;
  const biss::FrameBounds within = bounds == nullptr ? biss::FrameBounds{} : bounds_from_c(*bounds);
  const biss::BitView bits(std::span(bytes, byte_count), first_bit, bit_count);
  *frame = as_c(biss::decode_frame(bits, prepared, within));
  if (frame->cause != BISS_CAUSE_OK) return BISS_OK;
  for (const biss::ChannelFormat& channel : prepared.format().channels()) {
    frame->no_error_flag |= channel.position_bits() != 0 && !channel.error.present;
    frame->unchecked |= !channel.crc.present();
  }
  return BISS_OK;
}

biss_status biss_frame_defaults(const biss_codec* codec, biss_frame* frame) {
  if (const auto wrong = check_call(codec, frame)) return wrong;
  *frame = {};
  frame->channel_count = thing<Codec>(codec).format().channel_count;
  for (biss_channel& channel : frame->channels) channel.nE = channel.nW = true;
  frame->lead_clocks = frame->ack_clocks = 1;
  return BISS_OK;
}

biss_status biss_frame_encode(const biss_codec* codec, const biss_frame* frame, uint8_t* bytes,
                              size_t byte_count, size_t* bit_count) {
  if (const auto wrong = check_call(codec, frame, bit_count, given(bytes, byte_count)))
    return wrong;
  if (frame->channel_count != thing<Codec>(codec).format().channel_count) return BISS_CHANNEL_COUNT;
  constexpr biss::FrameBounds widest;
  if (frame->lead_clocks > widest.lead_max_clocks || frame->ack_clocks > widest.ack_max_clocks) {
    return BISS_CLOCK_RANGE;
  }
  const auto bits = biss::encode_frame(from_c(*frame), thing<Codec>(codec));
  if (!bits.ok()) return status_of(bits.error());
  *bit_count = bits->size_bits();
  const std::span<const std::uint8_t> encoded = bits->bytes();
  if (encoded.size() > byte_count) return BISS_NO_ROOM;
  std::copy(encoded.begin(), encoded.end(), bytes);
  return BISS_OK;
}

biss_crc biss_crc_defaults(uint32_t width_bits) {
  const bool usual = width_bits <= biss::max_crc_bits;
  return {usual ? biss::default_polynomial(width_bits) : 0, 0, width_bits, true, {}, {}, {}, {}};
}

biss_status biss_crc_of(const biss_crc* crc, uint64_t data, uint32_t bits, uint32_t* value) {
  if (crc == nullptr || value == nullptr) return BISS_NULL_ARGUMENT;
  const biss::CrcSpec spec = crc_from_c(*crc);
  if (!is_possible(*crc) || spec.deviates()) return BISS_BAD_CRC;
  if (bits < 1 || bits > biss::max_data_bits) return BISS_BIT_COUNT;
  if ((data & ~biss::low_mask(bits)) != 0) return BISS_VALUE_RANGE;
  *value = biss::CrcBitwise(spec)(data, bits);
  return BISS_OK;
}

}  // extern "C"
