// Decodes bits to a frame. The same functions read the bits of a capture and of an SPI buffer.
//
// Five ways give the same frame. The first three read only good frames with STOP; the last two read
// from START on and find every cause:
//
//   way              reads                                     runs
//   decode_one_word  CDS to STOP, one word of 64 bits          in the caller, format of one word
//   decode_words     a word for each channel, few channels     in the caller
//   decode_words     a word for each channel, many channels    in decode_apart()
//   read_found       one word                                  after START, format of one word
//   read_payload     channel by channel                        after START, any other format
//
// decode_here() chooses between the first two. If that gives no frame, decode_apart() tries the
// third and then decode_in_steps(): START is searched, and read_after_start() chooses between the
// last two. A processor of 32 bits (`selects` is false) goes to decode_in_steps() at once.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"

namespace biss::frame_detail {

// ---- The channels after CDS

// Channel k, whose first bit is at `at`; `at` moves to the next channel. False: the CRC is wrong,
// or belongs to the previous frame.
template <class Crc, class Frame>
[[gnu::always_inline]] constexpr bool read_channel(const BitView& bits, std::size_t& at,
                                                   const ChannelFormat& channel, const Crc& crc,
                                                   std::size_t k, Frame& frame) {
  const std::uint64_t data = bits.word(at, channel.data_bits);
  at += channel.data_bits;
  if (channel.crc.present()) {
    if (bits.word(at, channel.crc.width_bits) != crc(k, data) || channel.crc.of_previous) {
      return false;
    }
    at += channel.crc.width_bits;
  }
  unpack_into(channel, data, frame.channel_list[k]);
  return true;
}

// Several channels that are known while compiling: each is read with its own constants instead of
// values from memory.
template <class Codec>
inline constexpr bool has_fixed_channels = false;
template <class Codec>
requires(Codec::fixed_channels > 1) inline constexpr bool has_fixed_channels<Codec> = true;

template <std::size_t K, class Codec>
[[gnu::always_inline]] constexpr bool read_fixed_channel(const BitView& bits, std::size_t& at,
                                                         const Codec&, typename Codec::Frame& frame,
                                                         std::size_t& read) {
  const auto crc = [&frame](std::size_t, std::uint64_t channel_data) {
    return Codec::template crc_of<K>(channel_data, frame.cds);
  };
  const bool right = read_channel(bits, at, Codec::format().channel_list[K], crc, K, frame);
  read += right ? 1U : 0U;
  return right;
}

// All channels. Returns the first channel with a wrong CRC, or the number of channels.
template <class Codec, std::size_t... K>
[[gnu::always_inline]] constexpr std::size_t read_fixed_channels(const BitView& bits,
                                                                 std::size_t at, const Codec& codec,
                                                                 typename Codec::Frame& frame,
                                                                 std::index_sequence<K...>) {
  std::size_t read = 0;
  static_cast<void>((read_fixed_channel<K>(bits, at, codec, frame, read) && ...));
  return read;
}

// All channels from their first bit on. Returns the first channel with a wrong CRC, or the number
// of channels.
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
      return codec.crc(channel_index, channel_data, frame.cds);
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

// One object, so that no call has to build it.
inline constexpr FrameBounds widest_bounds{};

template <class Codec>
using Outcome = Result<typename Codec::Frame, FrameFault>;

// A frame's place, and the word from CDS on, as BitView::window() gives it.
struct QuickStart {
  std::uint64_t word = 0;
  // BitView::head() with its bits inverted.
  std::uint64_t zeros = 0;
  std::size_t start_bit = 0;
  // The word is all that BitView::head() has from CDS on, then zeros.
  bool is_in_head = false;

  constexpr unsigned lead_clocks() const {
    return static_cast<unsigned>(std::countl_zero(zeros | 1U));
  }
  constexpr std::size_t ack_clocks() const { return start_bit - lead_clocks(); }
};

constexpr bool is_lead(const FrameBounds& bounds, unsigned lead) {
  return lead >= bounds.lead_min_clocks && lead <= bounds.lead_max_clocks;
}

constexpr bool is_ack(const FrameBounds& bounds, std::size_t ack) {
  return ack >= bounds.ack_min_clocks && ack <= bounds.ack_max_clocks;
}

// FrameBounds for the zeros of BitView::head().
struct QuickBounds {
  // The inverted zeros are a number from `least` to below `end`: the first of them ends the leading
  // ones.
  std::uint64_t least;
  std::uint64_t end;
  // Every ACK within a word is allowed. Not bool: after a fault of the memory it still has a value.
  std::uint8_t any_ack;

  constexpr explicit QuickBounds(const FrameBounds& bounds)
      : least(std::uint64_t{1} << (63U - std::min<unsigned>(bounds.lead_max_clocks, 63))),
        end(std::uint64_t{1} << (64U - std::clamp<unsigned>(bounds.lead_min_clocks, 1, 64))),
        any_ack(bounds.ack_min_clocks <= 1 && bounds.ack_max_clocks >= 64 ? 1 : 0) {}
};

// Finds START within the bounds, with `clocks` of the line from START on. Its branches go the same
// way from frame to frame if ACK keeps about the same length. False: not found, or no such frame;
// search_start() then finds the cause.
[[gnu::always_inline]] constexpr bool find_quick(const BitView& bits, const FrameBounds& bounds,
                                                 const QuickBounds& quick, std::size_t clocks,
                                                 std::uint64_t last_ack, QuickStart& found) {
  const std::uint64_t head = bits.head();
  const std::uint64_t zeros = ~head;
  // The zeros before a one; the first one is the last of ACK.
  const std::uint64_t acks = zeros & (head << 1U);
  if (bits.size_bits() < 64 &&
      acks < last_ack_of(clocks, std::min(bits.size_bits(), bits.head_bits()))) {
    return false;
  }
  if (zeros < quick.least || zeros >= quick.end) return false;
  found.zeros = zeros;
  if (acks >= last_ack) [[likely]] {
    const auto last = static_cast<unsigned>(std::countl_zero(acks | 1U));
    found.start_bit = last + 1U;
    found.word = (head << 2U) << last;
    found.is_in_head = true;
    return quick.any_ack != 0 || is_ack(bounds, found.ack_clocks());
  }
  if (bits.size_bits() < 64) return false;
  found.start_bit =
      acks != 0 ? static_cast<unsigned>(std::countl_zero(acks)) + 1U : bits.find_one_after_head();
  if (!is_ack(bounds, found.ack_clocks())) return false;
  if (found.start_bit + clocks > bits.size_bits()) return false;
  found.word = bits.window_of_many(found.start_bit + 1U);
  return true;
}

constexpr FrameStart start_of(const QuickStart& found) {
  return {found.start_bit, static_cast<std::uint16_t>(found.lead_clocks()),
          static_cast<std::uint16_t>(found.ack_clocks())};
}

// The index of ACK if zeros precede the leading ones; 0: not within the bounds.
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

// Like decode_payload(), step by step, into a frame that has its defaults.
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
    frame_detail::QuickStart found;
    if (frame_detail::find_quick(bits, bounds, frame_detail::QuickBounds(bounds), 2,
                                 frame_detail::last_ack_of(2), found))
      return frame_detail::start_of(found);
  }
  return frame_detail::search_start(bits, bounds);
}

namespace frame_detail {

// A channel from its word. False: the CRC is wrong, STOP is 1, or CDS is 1 although it must be 0.
template <class Codec>
[[gnu::always_inline]] constexpr bool read_word(std::uint64_t word, const Codec& codec,
                                                std::size_t k, Channel& channel) {
  const WordPlan& plan = codec.plan(k);
  if (!plan.is_low(word) || !codec.engine(k).is_right(word)) return false;
  channel.position = plan.in_pieces() ? position_of(codec.format().channel_list[k], plan.data(word))
                                      : plan.position(word);
  plan.unpack_flags_into(word, channel);
  return true;
}

// The same for the channel of a format that is one word.
template <class Codec>
[[gnu::always_inline]] constexpr bool read_one_word(std::uint64_t word, const Codec& codec,
                                                    Channel& channel) {
  const WordPlan& plan = codec.plan(0);
  if (!plan.is_low(word) || !codec.engine(0).is_right(word)) return false;
  channel.position = plan.position(word);
  plan.unpack_flags_into(word, channel);
  return true;
}

// Few channels are read with a piece of code for each, so that the frame can stay in registers.
template <class Codec>
inline constexpr bool has_few_channels =
    has_fixed_channels<Codec> || std::tuple_size_v<decltype(Codec::Frame::channel_list)> == 2;

template <std::size_t K, class Codec>
[[gnu::always_inline]] constexpr bool read_one_of_few(const BitView& bits, std::size_t& at,
                                                      std::uint64_t word, const Codec& codec,
                                                      typename Codec::Frame& frame) {
  if (K >= codec.format().channel_count) return true;
  if constexpr (K > 0) word = bits.window(at);
  at += codec.plan(K).total_bits();
  return read_word(word, codec, K, frame.channel_list[K]);
}

template <class Codec, std::size_t... K>
[[gnu::always_inline]] constexpr bool read_few_words(const BitView& bits, std::size_t at,
                                                     std::uint64_t word, const Codec& codec,
                                                     typename Codec::Frame& frame,
                                                     std::index_sequence<K...>) {
  return (read_one_of_few<K>(bits, at, word, codec, frame) && ...);
}

// Every channel of a good and complete frame, STOP included. `word` begins with CDS, at `cds_at`.
// False: a check fails; read_payload() then finds the cause.
template <class Codec>
[[gnu::always_inline]] constexpr bool read_words(const BitView& bits, std::size_t cds_at,
                                                 std::uint64_t word, const Codec& codec,
                                                 typename Codec::Frame& frame) {
  if constexpr (has_few_channels<Codec>) {
    constexpr std::size_t most = std::tuple_size_v<decltype(Codec::Frame::channel_list)>;
    return read_few_words(bits, cds_at, word, codec, frame, std::make_index_sequence<most>());
  } else {
    const std::size_t count = codec.format().channel_count;
    for (std::size_t k = 0;;) {
      if (!read_word(word, codec, k, frame.channel_list[k])) return false;
      cds_at += codec.plan(k).total_bits();
      if (++k == count) return true;
      word = bits.window(cds_at);
    }
  }
}

// Finds a good frame with STOP, and its word from CDS on.
template <class Codec>
[[gnu::always_inline]] constexpr bool begin_quick(const BitView& bits, const Codec& codec,
                                                  const FrameBounds& bounds,
                                                  const QuickBounds& quick, std::uint64_t last_ack,
                                                  typename Codec::Frame& frame, QuickStart& found) {
  if (!find_quick(bits, bounds, quick, codec.clocks(), last_ack, found)) return false;
  frame.channel_count = codec.format().channel_count;
  frame.cds = WordPlan::cds(found.word);
  frame.stop_seen = true;
  frame.lead_clocks = static_cast<std::uint16_t>(found.lead_clocks());
  frame.ack_clocks = static_cast<std::uint16_t>(found.ack_clocks());
  return true;
}

// Like decode_frame() for a good frame with STOP of a format that fits windows, if `accepts`
// returns true for its start; false for all others.
template <class Codec, class Accepts>
[[gnu::always_inline]] constexpr bool decode_words(const BitView& bits, const Codec& codec,
                                                   const FrameBounds& bounds,
                                                   const QuickBounds& quick, std::uint64_t last_ack,
                                                   typename Codec::Frame& frame,
                                                   const Accepts& accepts) {
  QuickStart found;
  return begin_quick(bits, codec, bounds, quick, last_ack, frame, found) && accepts(found) &&
         read_words(bits, found.start_bit + 1U, found.word, codec, frame);
}

// The same for a format that is one word.
template <class Codec, class Accepts>
[[gnu::always_inline]] constexpr bool decode_one_word(const BitView& bits, const Codec& codec,
                                                      const FrameBounds& bounds,
                                                      const QuickBounds& quick,
                                                      typename Codec::Frame& frame,
                                                      const Accepts& accepts) {
  QuickStart found;
  return begin_quick(bits, codec, bounds, quick, codec.last_ack(), frame, found) &&
         (found.is_in_head || codec.one_word()) && accepts(found) &&
         read_one_word(found.word, codec, frame.channel_list[0]);
}

// Like read_payload() for a format that is one word.
template <class Codec>
constexpr std::optional<FrameFault> read_found(const BitView& bits, const FrameStart& start,
                                               const Codec& codec, typename Codec::Frame& frame) {
  const WordPlan& plan = codec.plan(0);
  const std::size_t stop = start.start_bit + 2U + codec.payload_bits();
  if (stop > bits.size_bits()) return FrameFault{FrameError::truncated};
  const std::uint64_t word = bits.window(start.start_bit + 1U);
  frame.cds = WordPlan::cds(word);
  if (frame.cds && codec.format().cds0) return FrameFault{FrameError::cds};
  if (!codec.engine(0).is_right(word)) return FrameFault{FrameError::crc};
  frame.stop_seen = stop < bits.size_bits();
  if (frame.stop_seen && plan.stop(word)) return FrameFault{FrameError::stop_bit};
  frame.channel_count = 1;
  frame.lead_clocks = start.lead_clocks;
  frame.ack_clocks = start.ack_clocks;
  frame.channel_list[0].position = plan.position(word);
  plan.unpack_flags_into(word, frame.channel_list[0]);
  return std::nullopt;
}

// Every cause of a format that is one word is found in its word; a second way would only be more
// code.
template <class Codec>
constexpr std::optional<FrameFault> read_after_start(const BitView& bits, const FrameStart& start,
                                                     const Codec& codec,
                                                     typename Codec::Frame& frame) {
  if constexpr (Codec::may_be_one_word) {
    if (codec.one_word()) return read_found(bits, start, codec, frame);
  }
  return read_payload(bits, start, codec, frame);
}

// Not inlined: it finds the cause if find_narrow() finds nothing.
[[gnu::noinline]] constexpr Result<FrameStart, FrameFault> search_start_apart(
    BitView bits, const FrameBounds& bounds) {
  return search_start(bits, bounds);
}

// Like find_quick() for registers of 32 bits: START alone.
[[gnu::always_inline]] constexpr bool find_narrow(const BitView& bits, const FrameBounds& bounds,
                                                  FrameStart& found) {
  const std::uint32_t head = bits.narrow_head();
  if (static_cast<std::int32_t>(head) >= 0) return false;
  const auto lead = static_cast<unsigned>(std::countl_one(head));
  if (lead >= bits.narrow_head_bits() || !is_lead(bounds, lead)) return false;
  const std::uint32_t rest = head << lead;
  found.start_bit = rest != 0 ? lead + static_cast<unsigned>(std::countl_zero(rest))
                              : bits.narrow_find_one_after_head();
  found.lead_clocks = static_cast<std::uint16_t>(lead);
  found.ack_clocks = static_cast<std::uint16_t>(found.start_bit - lead);
  return is_ack(bounds, found.start_bit - lead) && found.start_bit < bits.size_bits();
}

// Step by step, into a frame that has its defaults.
template <class Codec>
constexpr std::optional<FrameFault> decode_in_steps(const BitView& bits, const Codec& codec,
                                                    const FrameBounds& bounds,
                                                    typename Codec::Frame& frame) {
  FrameStart start;
  if (selects || !find_narrow(bits, bounds, start)) {
    const auto searched = search_start_apart(bits, bounds);
    if (!searched.ok()) return searched.error();
    start = *searched;
  }
  return read_after_start(bits, start, codec, frame);
}

inline constexpr auto accepts_all = [](const QuickStart&) { return true; };

// Not inlined, and by value, so that the caller keeps its registers.
template <class Codec>
[[gnu::noinline]] constexpr Outcome<Codec> decode_apart(std::span<const std::uint8_t> stored,
                                                        std::size_t first_bit,
                                                        std::size_t size_bits, const Codec& codec,
                                                        const FrameBounds& bounds) {
  const BitView bits(stored, first_bit, size_bits);
  Outcome<Codec> result = empty_frame<typename Codec::Frame>;
  if constexpr (Codec::may_fit_windows && !has_few_channels<Codec>) {
    if (codec.fits_windows() && !codec.one_word()) {
      if (decode_words(bits, codec, bounds, QuickBounds(bounds), last_ack_of(codec.clocks()),
                       result.value(), accepts_all)) {
        return result;
      }
      result = empty_frame<typename Codec::Frame>;
    }
  }
  const auto fault = decode_in_steps(bits, codec, bounds, result.value());
  if (fault) result = failure(*fault);
  return result;
}

// A copy by parts, so that the compiler can keep `to` in registers.
template <class Frame>
[[gnu::always_inline]] constexpr void copy_parts(const Frame& from, Frame& to) {
  for (std::size_t k = 0; k < from.channel_list.size(); ++k) {
    to.channel_list[k].position = from.channel_list[k].position;
    to.channel_list[k].life_counter = from.channel_list[k].life_counter;
    to.channel_list[k].nE = from.channel_list[k].nE;
    to.channel_list[k].nW = from.channel_list[k].nW;
  }
  to.channel_count = from.channel_count;
  to.cds = from.cds;
  to.stop_seen = from.stop_seen;
  to.lead_clocks = from.lead_clocks;
  to.ack_clocks = from.ack_clocks;
}

// Decoded inline: a format of one word, or of few channels.
template <class Codec, class Accepts>
[[gnu::always_inline]] constexpr bool decode_here(const BitView& bits, const Codec& codec,
                                                  const FrameBounds& bounds,
                                                  const QuickBounds& quick,
                                                  typename Codec::Frame& frame,
                                                  const Accepts& accepts) {
  if constexpr (has_few_channels<Codec> && Codec::may_fit_windows) {
    return codec.fits_windows() &&
           decode_words(bits, codec, bounds, quick, codec.last_ack(), frame, accepts);
  } else if constexpr (Codec::may_be_one_word) {
    return decode_one_word(bits, codec, bounds, quick, frame, accepts);
  } else {
    return false;
  }
}

}  // namespace frame_detail

/// Decodes CDS, the channels and STOP after a START that was found.
/// \return the frame, or truncated, cds, crc, stop_bit. Bits that end before STOP are not an error.
template <class Codec>
constexpr Result<typename Codec::Frame, FrameFault> decode_payload(const BitView& bits,
                                                                   const FrameStart& start,
                                                                   const Codec& codec) {
  // The one object that is returned, so that it is built in the caller's memory.
  frame_detail::Outcome<Codec> result = frame_detail::empty_frame<typename Codec::Frame>;
  const auto fault = frame_detail::read_after_start(bits, start, codec, result.value());
  if (fault) result = failure(*fault);
  return result;
}

/// Finds and decodes a frame.
/// \param bits as for find_start(); bits after STOP are ignored
/// \return the frame, or the first cause on the line why there is none (any FrameError)
template <class Codec>
[[gnu::always_inline]] constexpr Result<typename Codec::Frame, FrameFault> decode_frame(
    const BitView& bits, const Codec& codec,
    const FrameBounds& bounds = frame_detail::widest_bounds) {
  // The one object that is returned, so that it is built in the caller's memory.
  frame_detail::Outcome<Codec> result = frame_detail::empty_frame<typename Codec::Frame>;
  if constexpr (frame_detail::selects) {
    const frame_detail::QuickBounds quick(bounds);
    if (!frame_detail::decode_here(bits, codec, bounds, quick, result.value(),
                                   frame_detail::accepts_all)) [[unlikely]] {
      // A copy by parts, so that the compiler can keep `result` and `bits` in registers.
      frame_detail::Outcome<Codec> apart = frame_detail::decode_apart(
          bits.stored(), bits.first_bit_of_stored(), bits.size_bits(), codec, bounds);
      if (apart.ok()) {
        frame_detail::copy_parts(apart.value(), result.value());
      } else {
        result = failure(apart.error());
      }
    }
  } else {
    const auto fault = frame_detail::decode_in_steps(bits, codec, bounds, result.value());
    if (fault) result = failure(*fault);
  }
  return result;
}

}  // namespace biss
