// Decodes bits to a frame. The same functions read the bits of a capture and of an SPI buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss::frame_detail {

// ---- The channels after CDS

// Channel k, whose first bit is at `at`; `at` moves to the next channel. False: the CRC is wrong.
template <class Crc, class Frame>
[[gnu::always_inline]] constexpr bool read_channel(const BitView& bits, std::size_t& at,
                                                   const ChannelFormat& channel, const Crc& crc,
                                                   std::size_t k, Frame& frame) {
  const std::uint64_t data = bits.word(at, channel.data_bits);
  at += channel.data_bits;
  if (channel.crc.present()) {
    if (bits.word(at, channel.crc.width_bits) != crc(k, data)) return false;
    at += channel.crc.width_bits;
  }
  unpack_into(channel, data, frame.channel_list[k]);
  return true;
}

// Several channels that are known while compiling: each is read with its own numbers, instead of
// all with what is loaded from memory.
template <class Codec>
inline constexpr bool has_fixed_channels = false;
template <class Codec>
requires(Codec::fixed_channels > 1) inline constexpr bool has_fixed_channels<Codec> = true;

template <std::size_t K, class Codec>
[[gnu::always_inline]] constexpr bool read_fixed_channel(const BitView& bits, std::size_t& at,
                                                         const Codec&, typename Codec::Frame& frame,
                                                         std::size_t& read) {
  const auto crc = [](std::size_t, std::uint64_t channel_data) {
    return Codec::template crc_of<K>(channel_data);
  };
  const bool right = read_channel(bits, at, Codec::format().channel_list[K], crc, K, frame);
  read += right ? 1U : 0U;
  return right;
}

// All channels. Returns the first one whose CRC is wrong, or their number.
template <class Codec, std::size_t... K>
[[gnu::always_inline]] constexpr std::size_t read_fixed_channels(const BitView& bits,
                                                                 std::size_t at, const Codec& codec,
                                                                 typename Codec::Frame& frame,
                                                                 std::index_sequence<K...>) {
  std::size_t read = 0;
  static_cast<void>((read_fixed_channel<K>(bits, at, codec, frame, read) && ...));
  return read;
}

// All channels from their first bit on. Returns the first one whose CRC is wrong, or their number.
template <class Codec>
[[gnu::always_inline]] constexpr std::size_t read_channels(const BitView& bits, std::size_t at,
                                                           const Codec& codec,
                                                           typename Codec::Frame& frame) {
  if constexpr (has_fixed_channels<Codec>) {
    return read_fixed_channels(bits, at, codec, frame,
                               std::make_index_sequence<Codec::fixed_channels>());
  } else {
    const std::size_t count = codec.format().channel_count;
    const auto crc = [&](std::size_t channel_index, std::uint64_t channel_data) {
      return codec.crc(channel_index, channel_data);
    };
    for (std::size_t k = 0; k < count; ++k) {
      if (!read_channel(bits, at, codec.format().channel_list[k], crc, k, frame)) return k;
    }
    return count;
  }
}

}  // namespace biss::frame_detail

namespace biss {

/// The start of a frame in a run of bits.
struct FrameStart {
  std::size_t start_bit = 0;  ///< index of START
  std::uint16_t lead_clocks = 0;
  std::uint16_t ack_clocks = 0;
};

namespace frame_detail {

// Copied instead of built channel by channel.
template <class Frame>
inline constexpr Frame empty_frame{};

template <class Codec>
using Outcome = Result<typename Codec::Frame, FrameFault>;

constexpr bool within(const FrameBounds& bounds, std::size_t ones, std::size_t zeros) {
  return ones != 0 && ones >= bounds.lead_min_clocks && ones <= bounds.lead_max_clocks &&
         zeros >= bounds.ack_min_clocks && zeros <= bounds.ack_max_clocks;
}

constexpr FrameStart start_after(const BitView::OnesZerosOne& runs) {
  return {runs.ones + runs.zeros, static_cast<std::uint16_t>(runs.ones),
          static_cast<std::uint16_t>(runs.zeros)};
}

// The index of ACK where zeros precede the leading ones; 0: not within the bounds.
[[gnu::noinline, gnu::cold]] constexpr std::size_t late_ack(BitView bits, FrameBounds bounds) {
  const std::size_t ones = bits.find(true, 0);
  if (ones > bounds.late_max_clocks) return 0;
  const std::size_t ack = bits.find(false, ones);
  const bool in_time =
      ack < bits.size_bits() && ack >= bounds.lead_min_clocks && ack <= bounds.lead_max_clocks;
  return in_time ? ack : 0;
}

// Like find_start(), by two searches and with every cause.
constexpr Result<FrameStart, FrameFault> search_start(const BitView& bits,
                                                      const FrameBounds& bounds) {
  std::size_t ack = bits.find(false, 0);
  if (ack == bits.size_bits()) return failure(FrameFault{FrameError::no_response});
  if (ack == 0 && bounds.late_max_clocks != 0) ack = late_ack(bits, bounds);
  if (ack == 0) return failure(FrameFault{FrameError::not_ready});
  if (ack < bounds.lead_min_clocks || ack > bounds.lead_max_clocks) {
    return failure(FrameFault{FrameError::response_range});
  }
  const std::size_t start = bits.find(true, ack);
  if (start == bits.size_bits()) return failure(FrameFault{FrameError::no_start});
  const std::size_t ack_clocks = start - ack;
  if (ack_clocks < bounds.ack_min_clocks || ack_clocks > bounds.ack_max_clocks) {
    return failure(FrameFault{FrameError::ack_range});
  }
  return FrameStart{start, static_cast<std::uint16_t>(ack), static_cast<std::uint16_t>(ack_clocks)};
}

// Like decode_payload(), into a frame that has its defaults.
template <class Codec>
constexpr std::optional<FrameFault> read_payload(const BitView& bits, const FrameStart& start,
                                                 const Codec& codec, typename Codec::Frame& frame) {
  const FrameFormat& format = codec.format();
  const std::size_t at = start.start_bit + 2;
  const std::size_t stop = at + codec.payload_bits();
  if (stop > bits.size_bits()) return FrameFault{FrameError::truncated};
  frame.cds = bits[at - 1];
  if (frame.cds && format.cds0) return FrameFault{FrameError::cds};
  frame.channel_count = format.channel_count;
  frame.lead_clocks = start.lead_clocks;
  frame.ack_clocks = start.ack_clocks;
  const std::size_t read = read_channels(bits, at, codec, frame);
  if (read < format.channel_count) {
    return FrameFault{FrameError::crc, static_cast<std::uint8_t>(read)};
  }
  if (stop < bits.size_bits()) {
    if (bits[stop]) return FrameFault{FrameError::stop_bit};
    frame.stop_seen = true;
  }
  return std::nullopt;
}

}  // namespace frame_detail

/// Finds ACK and START.
/// \param bits SLO once a MA clock from the first on: ones (LAT, line delay), zeros (ACK), START, …
/// \return the place of START, or no_response, not_ready, response_range, no_start, ack_range
constexpr Result<FrameStart, FrameFault> find_start(const BitView& bits,
                                                    const FrameBounds& bounds) {
  if constexpr (frame_detail::selects) {
    const auto runs = bits.ones_zeros_one();
    if (runs && frame_detail::within(bounds, runs->ones, runs->zeros)) {
      return frame_detail::start_after(*runs);
    }
  }
  return frame_detail::search_start(bits, bounds);
}

/// Decodes CDS, the channels and STOP after a START that was found.
/// \return the frame, or truncated, cds, crc, stop_bit. Bits that end before STOP are no error.
template <class Codec>
constexpr Result<typename Codec::Frame, FrameFault> decode_payload(const BitView& bits,
                                                                   const FrameStart& start,
                                                                   const Codec& codec) {
  // The one object that is returned, so that it is built where the caller wants it.
  frame_detail::Outcome<Codec> result = frame_detail::empty_frame<typename Codec::Frame>;
  const auto fault = frame_detail::read_payload(bits, start, codec, result.value());
  if (fault) result = failure(*fault);
  return result;
}

namespace frame_detail {

// Decodes a good frame, STOP included, of a format that is one word: nearly all frames. False
// leaves `frame` unchanged; read_payload() then finds the cause.
template <class Codec>
constexpr bool read_word(const BitView& bits, const FrameStart& start, const Codec& codec,
                         typename Codec::Frame& frame) {
  const WordPlan& plan = codec.plan();
  const std::size_t cds_at = start.start_bit + 1U;
  if (cds_at + plan.payload_bits() + 2U > bits.size_bits()) return false;
  const std::uint64_t word = bits.window(cds_at);
  const std::uint64_t data = plan.data(word);
  if (!plan.is_low(word) || plan.crc(word) != codec.crc(0, data)) return false;
  frame.channel_count = 1;
  frame.cds = plan.cds(word);
  frame.stop_seen = true;
  frame.lead_clocks = start.lead_clocks;
  frame.ack_clocks = start.ack_clocks;
  plan.unpack_into(data, frame.channel_list[0]);
  return true;
}

// Step by step, into a frame that has its defaults.
template <class Codec>
constexpr void decode_in_steps(const BitView& bits, const Codec& codec, const FrameBounds& bounds,
                               Outcome<Codec>& result) {
  const auto start = find_start(bits, bounds);
  if constexpr (Codec::may_be_one_word && !selects) {
    if (start.ok() && codec.one_word() && read_word(bits, *start, codec, result.value())) return;
  }
  const auto fault =
      start.ok() ? read_payload(bits, *start, codec, result.value()) : std::optional(start.error());
  if (fault) result = failure(*fault);
}

// Not inlined, so that decode_quick() keeps its registers.
template <class Codec>
[[gnu::noinline]] constexpr void decode_apart(const BitView& bits, const Codec& codec,
                                              const FrameBounds& bounds, Outcome<Codec>& result) {
  decode_in_steps(bits, codec, bounds, result);
}

// Like decode_frame() for a good frame that is one word; false for all others.
template <class Codec>
constexpr bool decode_quick(const BitView& bits, const Codec& codec, const FrameBounds& bounds,
                            typename Codec::Frame& frame) {
  if (!codec.one_word()) return false;
  const auto runs = bits.ones_zeros_one();
  if (!runs || !within(bounds, runs->ones, runs->zeros)) return false;
  return read_word(bits, start_after(*runs), codec, frame);
}

}  // namespace frame_detail

/// Finds and decodes a frame.
/// \param bits as for find_start(); bits after STOP are ignored
/// \return the frame, or the first cause on the line why there is none (any FrameError)
template <class Codec>
constexpr Result<typename Codec::Frame, FrameFault> decode_frame(const BitView& bits,
                                                                 const Codec& codec,
                                                                 const FrameBounds& bounds = {}) {
  // The one object that is returned, so that it is built where the caller wants it.
  frame_detail::Outcome<Codec> result = frame_detail::empty_frame<typename Codec::Frame>;
  if constexpr (frame_detail::selects && Codec::may_be_one_word) {
    if (!frame_detail::decode_quick(bits, codec, bounds, result.value())) {
      // Copies, so that the originals can stay in registers.
      const BitView line = bits;
      const FrameBounds limits = bounds;
      frame_detail::decode_apart(line, codec, limits, result);
    }
  } else {
    frame_detail::decode_in_steps(bits, codec, bounds, result);
  }
  return result;
}

}  // namespace biss
