// biss_format, frames and checksums.
#include "capi/frame.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "biss/base/bits.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::capi {

namespace {

static_assert(BISS_FRAME_BITS_MAX == max_frame_bits);
static_assert(BISS_FRAME_BYTES_MAX == (max_frame_bits + 7U) / 8U);

biss_crc checksum_of(const CrcSpec& crc) {
  return {crc.polynomial, crc.start,         crc.width_bits, crc.inverted,
          crc.reversed,   crc.without_flags, crc.with_cds,   crc.of_previous};
}

bool is_possible(const biss_crc& crc) {
  return crc.width_bits >= min_crc_bits && crc.width_bits <= max_crc_bits &&
         is_full_form(crc.polynomial, crc.width_bits) && (crc.start >> crc.width_bits) == 0 &&
         !crc.reversed && !crc.without_flags && !crc.with_cds && !crc.of_previous;
}

CrcSpec from_c(const biss_crc& crc) {
  return {crc.polynomial, static_cast<std::uint16_t>(crc.start),
          static_cast<std::uint8_t>(crc.width_bits), crc.inverted};
}

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

biss_status put_text(const FrameFormat& format, char* text, std::size_t room, std::size_t* length) {
  const FormatText whole = format_text(format);
  const std::string_view view = whole.view();
  if (length != nullptr) *length = view.size();
  if (room <= view.size()) return BISS_NO_ROOM;
  std::copy(view.begin(), view.end(), text);
  text[view.size()] = '\0';
  return BISS_OK;
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

extern "C" {

biss_status biss_format_open(const char* text, biss_format** format) {
  if (format == nullptr) return BISS_NULL_ARGUMENT;
  *format = nullptr;
  if (text == nullptr) return BISS_NULL_ARGUMENT;
  const auto device = find_device(text);
  if (!device) return BISS_BAD_FORMAT;
  return open_handle(*format, *device);
}

void biss_format_close(biss_format* format) { destroy_handle(format); }

biss_status biss_format_channel(const biss_format* format, size_t index, biss_channel_format* out) {
  if (const auto wrong = check_call(format, out)) return wrong;
  const biss::FrameFormat& whole = format->codec.format();
  if (index >= whole.channel_count) return BISS_CHANNEL_COUNT;
  const biss::ChannelFormat& channel = whole.channel_list[index];
  *out = {.data_bits = channel.data_bits,
          .position_bits = channel.position_bits(),
          .singleturn_bits = channel.singleturn.bits,
          .life_counter_bits = channel.life_counter.bits,
          .has_error = channel.error.present,
          .has_warning = channel.warning.present,
          .crc = checksum_of(channel.crc)};
  return BISS_OK;
}

biss_status biss_format_size_of(const biss_format* format, biss_format_size* size) {
  if (const auto wrong = check_call(format, size)) return wrong;
  const biss::FrameFormat& whole = format->codec.format();
  *size = {whole.channel_count, whole.payload_bits(), whole.cds0};
  return BISS_OK;
}

biss_status biss_format_text(const biss_format* format, char* text, size_t room, size_t* length) {
  if (const auto wrong = check_call(format, text)) return wrong;
  return put_text(format->codec.format(), text, room, length);
}

bool biss_frame_trusted(const biss_frame* frame) {
  if (frame == nullptr || frame->cause != BISS_CAUSE_OK) return false;
  if (frame->no_error_flag || frame->unchecked) return false;
  if (frame->channel_count == 0 || frame->channel_count > BISS_MAX_CHANNELS) return false;
  return std::all_of(frame->channels, frame->channels + frame->channel_count,
                     [](const biss_channel& channel) { return channel.nE; });
}

biss_bounds biss_bounds_defaults(void) { return as_c(biss::FrameBounds{}); }

biss_status biss_frame_decode(const biss_format* format, const uint8_t* bytes, size_t byte_count,
                              size_t first_bit, size_t bit_count, const biss_bounds* bounds,
                              biss_frame* frame) {
  if (const auto wrong = check_call(format, frame, given(bytes, byte_count))) return wrong;
  if (bounds != nullptr && !is_possible(*bounds)) return BISS_BAD_SETUP;
  if (format->codec.format().needs_previous()) return BISS_BAD_FORMAT;
  const biss::FrameBounds within = bounds == nullptr ? biss::FrameBounds{} : bounds_from_c(*bounds);
  const biss::BitView bits(std::span(bytes, byte_count), first_bit, bit_count);
  *frame = as_c(biss::decode_frame(bits, format->codec, within));
  if (frame->cause != BISS_CAUSE_OK) return BISS_OK;
  for (const biss::ChannelFormat& channel : format->codec.format().channels()) {
    frame->no_error_flag |= channel.position_bits() != 0 && !channel.error.present;
    frame->unchecked |= !channel.crc.present();
  }
  return BISS_OK;
}

biss_status biss_frame_defaults(const biss_format* format, biss_frame* frame) {
  if (const auto wrong = check_call(format, frame)) return wrong;
  *frame = {};
  frame->channel_count = format->codec.format().channel_count;
  for (biss_channel& channel : frame->channels) channel.nE = channel.nW = true;
  frame->lead_clocks = frame->ack_clocks = 1;
  return BISS_OK;
}

biss_status biss_frame_encode(const biss_format* format, const biss_frame* frame, uint8_t* bytes,
                              size_t byte_count, size_t* bit_count) {
  if (const auto wrong = check_call(format, frame, bit_count, given(bytes, byte_count)))
    return wrong;
  if (frame->channel_count != format->codec.format().channel_count) return BISS_CHANNEL_COUNT;
  constexpr biss::FrameBounds widest;
  if (frame->lead_clocks > widest.lead_max_clocks || frame->ack_clocks > widest.ack_max_clocks) {
    return BISS_CLOCK_RANGE;
  }
  const auto bits = biss::encode_frame(from_c(*frame), format->codec);
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
  if (!is_possible(*crc)) return BISS_BAD_CRC;
  if (bits < 1 || bits > biss::max_data_bits) return BISS_BIT_COUNT;
  if ((data & ~biss::low_mask(bits)) != 0) return BISS_VALUE_RANGE;
  *value = biss::CrcBitwise(from_c(*crc))(data, bits);
  return BISS_OK;
}

}  // extern "C"
