// biss_codec, frames and checksums.
#include "capi/frame.hpp"

#include <algorithm>
#include <array>
#include <bit>
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

static_assert(offsetof(biss_channel, nW) == offsetof(Channel, nW) &&
              offsetof(biss_bounds, ack_max_clocks) == offsetof(FrameBounds, ack_max_clocks));
// One for each cause, in the order of FrameError.
static_assert(BISS_CAUSE_NO_RESPONSE == 1 + static_cast<int>(FrameError::no_response));
static_assert(BISS_CAUSE_STOP_BIT == 1 + static_cast<int>(FrameError::stop_bit));
static_assert(BISS_CAUSE_STOP_BIT == frame_error_count);
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
  result.channel_list = std::bit_cast<std::array<Channel, max_channels>>(frame.channels);
  result.cds = frame.cds;
  result.lead_clocks = static_cast<std::uint16_t>(frame.lead_clocks);
  result.ack_clocks = static_cast<std::uint16_t>(frame.ack_clocks);
  return result;
}

biss_status status_of(EncodeError error) {
  if (error == EncodeError::channel_count) return BISS_CHANNEL_COUNT;
  if (error == EncodeError::needs_previous) return BISS_BAD_FORMAT;
  const bool of_clocks = error == EncodeError::ack_range || error == EncodeError::lead_range;
  return of_clocks ? BISS_CLOCK_RANGE : BISS_VALUE_RANGE;
}

}  // namespace

void put(const Result<Frame, FrameFault>& from, biss_frame& to) {
  to = {};
  if (!put_result(from, to)) return;
  to.stop_seen = from->stop_seen;
  to.lead_clocks = from->lead_clocks;
  to.ack_clocks = from->ack_clocks;
}

using Codec = FrameCodec<>;

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

biss_bounds biss_bounds_defaults(void) { return std::bit_cast<biss_bounds>(FrameBounds{}); }

biss_status biss_frame_decode(const biss_codec* codec, const uint8_t* bytes, size_t byte_count,
                              size_t first_bit, size_t bit_count, const biss_bounds* bounds,
                              biss_frame* frame) {
  if (const auto wrong = check_call(codec, frame, given(bytes, byte_count))) return wrong;
  if (bounds != nullptr && !is_possible(*bounds)) return BISS_BAD_SETUP;
  const Codec& prepared = thing<Codec>(codec);
  if (prepared.format().needs_previous()) return BISS_BAD_FORMAT;
  FrameBounds within;
  if (bounds != nullptr) within = std::bit_cast<FrameBounds>(*bounds);
  const BitView bits(std::span(bytes, byte_count), first_bit, bit_count);
  put(decode_frame(bits, prepared, within), *frame);
  if (frame->cause != BISS_CAUSE_OK) return BISS_OK;
  for (const ChannelFormat& channel : prepared.format().channels()) {
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
  constexpr FrameBounds widest;
  if (frame->lead_clocks > widest.lead_max_clocks || frame->ack_clocks > widest.ack_max_clocks) {
    return BISS_CLOCK_RANGE;
  }
  const auto bits = encode_frame(from_c(*frame), thing<Codec>(codec));
  if (!bits.ok()) return status_of(bits.error());
  *bit_count = bits->size_bits();
  const std::span<const std::uint8_t> encoded = bits->bytes();
  if (encoded.size() > byte_count) return BISS_NO_ROOM;
  std::copy(encoded.begin(), encoded.end(), bytes);
  return BISS_OK;
}

biss_crc biss_crc_defaults(uint32_t width_bits) {
  const auto width = static_cast<std::uint8_t>(width_bits);
  const auto usual = width == width_bits ? default_polynomial(width) : 0;
  return std::bit_cast<biss_crc>(CrcSpec{usual, 0, width});
}

biss_status biss_crc_of(const biss_crc* crc, uint64_t data, uint32_t bits, uint32_t* value) {
  if (crc == nullptr || value == nullptr) return BISS_NULL_ARGUMENT;
  const CrcSpec spec = std::bit_cast<CrcSpec>(*crc);
  if (!is_checksum(spec) || spec.deviates()) return BISS_BAD_CRC;
  if (bits < 1 || bits > max_data_bits) return BISS_BIT_COUNT;
  if ((data & ~low_mask(bits)) != 0) return BISS_VALUE_RANGE;
  *value = CrcBitwise(spec)(data, bits);
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
