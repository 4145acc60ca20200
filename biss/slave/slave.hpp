// The encoder's side of the line, as a stepper: MA, SLI and time in, SLO and the next deadline out.
//
//   struct Encoder {
//     BasicFrame<1> sample(Picoseconds moment);  // the channels' values at that moment
//     bool cds(bool predecessor);                // the CDS bit, requested when it is sent
//     void cdm(bool bit);                        // the CDM bit, after a frame has ended
//   };
//   Slave slave(codec, slave_timing(device), Encoder{});
//   StepOutput out = slave.step(now, ma, sli);  // at each change of an input, and at out.deadline
//
// After the protocol description D2 and Renishaw's data sheet, without cable and internal delay.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <utility>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/timing/step.hpp"

namespace biss {

// ---- The timing of one slave

/// The timing of one slave: one device of a type that DeviceTiming describes, with one value for
/// each range of the type. The defaults: position sampled at LAT, answer ready immediately, the
/// longest timeout.
struct SlaveTiming {
  /// From the first rising edge of MA (LAT) to the moment at which the position is sampled; not
  /// negative.
  Picoseconds sampling{};
  /// From LAT: START never comes before this, nor before the sampling moment.
  Picoseconds start_min{};
  /// From the second rising edge (ACK) until the answer is ready: START comes with the first rising
  /// edge at or after that moment, at the earliest with the third.
  Picoseconds ready{};
  /// Clocks of ACK of a device that always takes the same number, in place of start_min and ready;
  /// 0: not fixed.
  std::uint16_t ack_clocks = 0;
  /// START comes this many clocks later than it could ("busy_s").
  std::uint8_t busy_s_clocks = 0;
  /// With the rule `cycle`, the time must be longer than 1.5 periods of MA.
  Timeout timeout{};
  /// With the rule `adaptive`, the timeout while the period of MA is not yet measured, and the
  /// longest that a measured one can be, so that MA held high always ends a frame.
  Picoseconds static_timeout = biss_static_timeout_max;
  /// SLI comes from another slave. False: SLI is tied low, and this slave makes START and STOP.
  bool chained = false;

  constexpr bool operator==(const SlaveTiming&) const = default;
};

/// The timing of a typical device of this type.
/// \param ready from ACK until it has its answer; limited to the type's longest
constexpr SlaveTiming slave_timing(const DeviceTiming& timing, Picoseconds ready = {}) {
  return {.sampling = timing.sampling_typical,
          .start_min = timing.start_min,
          .ready = std::min(ready, timing.ack_max),
          .ack_clocks = timing.ack_clocks,
          .timeout = timing.timeout};
}

// ---- The state of a slave, and its owner

/// The event that a slave waits for.
enum class SlaveState : std::uint8_t {
  idle,           ///< a falling edge of MA; SLO is 1
  requested,      ///< LAT, the first rising edge; SLO is still 1
  latched,        ///< ACK, the second rising edge; SLO is still 1
  ack,            ///< its answer, and the predecessor's START; SLO is 0
  start,          ///< the clock that sends CDS
  data,           ///< the clocks that send its own bits
  stop,           ///< the timeout; SLO is 0, or the predecessor's bits
  early_request,  ///< as `stop`: a request came before the timeout was over, and is not answered
  chain_busy,     ///< SLI = 1: its own timeout is over, a predecessor's is not; SLO is 0
};

/// The name that users see: the enumerator's name.
constexpr std::string_view name_of(SlaveState state) {
  constexpr std::string_view names[] = {"idle", "requested", "latched",       "ack",       "start",
                                        "data", "stop",      "early_request", "chain_busy"};
  return names[static_cast<std::size_t>(state)];
}

/// The owner of a slave; see the top of this file.
///
/// `cds(predecessor)` returns the bit to send; `predecessor` is CDS from SLI, 0 if the slave is not
/// chained. An owner without a bit to send returns `predecessor`. `cdm()` is called when the
/// timeout after an ACK is over, also if the clock stopped early: a frame may end without `cds()`.
template <class Source, class Codec>
concept SlaveSource = requires(Source source, Picoseconds moment) {
  { source.sample(moment) } -> std::convertible_to<typename Codec::Frame>;
  { source.cds(true) } -> std::same_as<bool>;
  source.cdm(true);
};

// ---- The bits from the predecessor in a chain

/// Room for CDS and the longest payload of all others, after a START that waited as long as BiSS C
/// allows. A power of two.
inline constexpr std::size_t slave_chain_bits = 1024;
static_assert(slave_chain_bits >= 1 + (max_channels - 1) * max_channel_bits + biss_ack_max_clocks);

namespace slave_detail {

/// First in, first out, from START on. When full, it drops new bits; when empty, it returns 0, as a
/// line after STOP.
template <std::size_t CapacityBits>
class ChainBits {
  static_assert(CapacityBits % 32 == 0);

 public:
  constexpr void clear() {
    first_ = size_ = 0;
    received_ = Received::nothing;
  }

  /// Takes SLI at a falling edge. START is the first 1 after a 0; it is not stored but generated
  /// again.
  constexpr void receive(bool sli) {
    if (received_ == Received::start) {
      push(sli);
    } else if (!sli) {
      received_ = Received::ack;
    } else if (received_ == Received::ack) {
      received_ = Received::start;
    }
  }
  constexpr bool started() const { return received_ == Received::start; }

  constexpr bool pop() {
    if (size_ == 0) return false;
    const std::size_t at = first_;
    first_ = (first_ + 1U) % CapacityBits;
    --size_;
    return ((words_[at / 32U] >> (at % 32U)) & 1U) != 0;
  }

 private:
  // The part that the predecessor has sent so far.
  enum class Received : std::uint8_t { nothing, ack, start };

  constexpr void push(bool bit) {
    if (size_ == CapacityBits) return;
    const std::size_t at = (first_ + size_++) % CapacityBits;
    const std::uint32_t mask = std::uint32_t{1} << (at % 32U);
    std::uint32_t& word = words_[at / 32U];
    word = bit ? word | mask : word & ~mask;
  }

  std::array<std::uint32_t, CapacityBits / 32U> words_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  Received received_ = Received::nothing;
};

/// For a slave that is not chained.
template <>
class ChainBits<0> {
 public:
  constexpr void clear() {}
  constexpr void receive(bool) {}
  constexpr bool started() const { return false; }
  constexpr bool pop() { return false; }
};

}  // namespace slave_detail

}  // namespace biss

namespace biss::slave_detail {

// ---- The bits of a frame

/// All channels of one frame, each with its CRC, in the order on the line.
template <class Codec>
class PayloadBits {
 public:
  using Frame = typename Codec::Frame;

  constexpr void clear() {
    bits_.clear();
    loaded_bits_ = 0;
    word_ = empty;
  }

  constexpr void take(const Codec& codec, const Frame& frame) {
    clear();
    const FrameFormat& format = codec.format();
    for (std::size_t k = 0; k < format.channel_count; ++k) {
      const ChannelFormat& channel = format.channel_list[k];
      const std::uint64_t data = pack(channel, frame.channel_list[k]);
      bits_.append(data, channel.data_bits);
      if (!channel.crc.present()) continue;
      std::uint16_t crc = codec.crc(k, data, false);
      if (channel.crc.of_previous) std::swap(crc, last_crc_[k]);
      bits_.append(crc, channel.crc.width_bits);
    }
  }

  /// CDS is 1: changes the checksums that cover it. \pre no bit has been loaded since take()
  constexpr void cover_cds(const Codec& codec) {
    std::size_t at = 0;
    for (std::size_t k = 0; k < codec.format().channel_count; ++k) {
      const ChannelFormat& channel = codec.format().channel_list[k];
      at += channel.total_bits();
      if (!channel.crc.with_cds || at > bits_.size_bits()) continue;
      const unsigned change = codec.crc(k, 0, true) ^ codec.crc(k, 0, false);
      if (channel.crc.of_previous) {
        last_crc_[k] = static_cast<std::uint16_t>(last_crc_[k] ^ change);
        continue;
      }
      for (unsigned i = 0; i < channel.crc.width_bits; ++i) {
        if (((change >> i) & 1U) != 0) bits_.flip(at - 1U - i);
      }
    }
  }

  /// Loads up to 63 more bits; false when all have been sent.
  /// \pre next() returned false
  constexpr bool load() {
    const auto count =
        static_cast<unsigned>(std::min<std::size_t>(63, bits_.size_bits() - loaded_bits_));
    if (count == 0) return false;
    word_ = (bits_.view().word(loaded_bits_, count) * 2U + 1U) << (63U - count);
    loaded_bits_ = static_cast<std::uint16_t>(loaded_bits_ + count);
    return true;
  }

  /// Takes the next loaded bit; false: there is none, and `bit` is unchanged.
  constexpr bool next(bool& bit) {
    const std::uint64_t rest = word_ << 1U;
    if (rest == 0) return false;
    bit = (word_ & empty) != 0;
    word_ = rest;
    return true;
  }

 private:
  static constexpr std::size_t channels = std::tuple_size_v<decltype(Frame::channel_list)>;

  BitBuffer<channels * max_channel_bits> bits_;
  // The loaded bits from the top down, with a 1 after the last.
  static constexpr std::uint64_t empty = std::uint64_t{1} << 63U;
  std::uint64_t word_ = empty;
  std::uint16_t loaded_bits_ = 0;
  // The CRCs of the previous frame; 0 before the first frame.
  std::array<std::uint16_t, channels> last_crc_{};
};

// ---- When a frame ends: the three timeout rules as one, "not before `floor`, and at least `wait`
// after the last edge"

class ReleaseTimer {
 public:
  /// Begins a request: MA's period is not known yet.
  constexpr void begin(const SlaveTiming& timing, Picoseconds now) {
    restart(timing, now);
    wait_ = Picoseconds{};
    if (timing.timeout.rule == TimeoutRule::fixed) wait_ = timing.timeout.time;
    if (timing.timeout.rule == TimeoutRule::adaptive) wait_ = timing.static_timeout;
  }

  /// The second rising edge of MA, 1.5 periods after begin().
  constexpr void measure(const SlaveTiming& timing, Picoseconds now) {
    reference_ = std::min(now - floor_begin_, timing.static_timeout);
    if (timing.timeout.rule == TimeoutRule::cycle) wait_ = release_wait(timing.timeout);
    if (timing.timeout.rule == TimeoutRule::adaptive) {
      wait_ = std::min(reference_ + timing.timeout.time, timing.static_timeout);
    }
  }

  /// The time of a cycle starts here.
  constexpr void restart(const SlaveTiming& timing, Picoseconds now) {
    floor_begin_ = now;
    floor_ = timing.timeout.rule == TimeoutRule::cycle ? now + timing.timeout.time : now;
  }

  /// The end of the frame if no edge follows this one.
  constexpr Picoseconds after(Picoseconds edge) const { return std::max(floor_, edge + wait_); }
  /// Moves `end`, the end of the frame without this edge, to the end with it.
  constexpr void extend(Picoseconds& end, Picoseconds edge) const {
    const std::int64_t extended = edge.count + wait_.count;
    if (extended > end.count) [[unlikely]]
      end.count = extended;
  }
  /// 1.5 periods of MA.
  constexpr Picoseconds reference() const { return reference_; }

 private:
  // Like release_time(), from the measured 1.5 periods: half a period is a third of that. A
  // multiplication replaces the 64-bit division, a call on microcontrollers; it is exact up to 2
  // ms.
  constexpr Picoseconds release_wait(const Timeout& timeout) const {
    const Picoseconds half{(reference_.count * 0x5555'5556) >> 32U};
    return reference_ + half * (timeout.release_half_periods - std::int64_t{3});
  }

  Picoseconds floor_{};
  Picoseconds wait_{};
  Picoseconds floor_begin_{};
  Picoseconds reference_{};
};

}  // namespace biss::slave_detail

namespace biss {

/// One slave with the channels of the codec's format.
///
/// `ChainBits` is the memory for a predecessor's bits; 0 if no slave is chained.
template <class Codec, SlaveSource<Codec> Source, std::size_t ChainBits = slave_chain_bits>
class Slave {
 public:
  /// Idle, with MA high. \pre timing is not chained if ChainBits is 0
  constexpr Slave(const Codec& codec, const SlaveTiming& timing, Source source)
      : codec_(codec), source_(source), timing_(timing) {}

  /// Call it at each change of `ma` or `sli` and at the deadline; further calls change nothing.
  /// Actions due by `now` come before the new levels: at an edge at the moment of sampling, the
  /// position is already sampled; at an edge at the end of the timeout, the slave is already idle.
  /// \param now not before the last step's
  /// \param sli ignored if the slave is not chained
  constexpr StepOutput step(Picoseconds now, bool ma, bool sli) {
    if (!step_in_data(now, ma, sli)) step_apart(now, ma, sli);
    return {level_, due_};
  }

  constexpr SlaveState state() const { return state_; }
  constexpr const SlaveTiming& timing() const { return timing_; }
  /// Changes the timing. \pre as for the constructor, and state() is idle
  constexpr void set_timing(const SlaveTiming& timing) { timing_ = timing; }
  /// Whether its channels are in the frame, from the next request on; at first they are. Without
  /// them, CDS is followed by STOP or the predecessor's channels, nothing is sampled, and the
  /// answer waits for no position: only fixed clocks of ACK and busy_s remain. May be called from
  /// the owner's functions.
  constexpr void set_channels_active(bool active) { channels_active_ = active; }
  constexpr bool channels_active() const { return channels_active_; }
  constexpr Source& source() { return source_; }
  constexpr const Codec& codec() const { return codec_; }

 private:
  // Most edges are clocks of data. False: this edge is not, and nothing was done.
  constexpr bool step_in_data(Picoseconds now, bool ma, bool sli) {
    if (awaited_ != static_cast<std::uint8_t>(ma) || now.count >= due_.count) return false;
    if (ma) {
      if (!payload_.next(level_)) return false;
    } else {
      receive(sli);
    }
    awaited_ = static_cast<std::uint8_t>(!ma);
    timer_.extend(due_, now);
    return true;
  }

  // Not inlined, so that step_in_data() keeps its registers.
  [[gnu::noinline, gnu::cold]] constexpr void step_apart(Picoseconds now, bool ma, bool sli) {
    if (state_ == SlaveState::data) ma_ = awaited_ == 0;
    if (now >= due_) expire(now, sli);
    if (ma != ma_) {
      ma_ = ma;
      ma ? rise(now, sli) : fall(now, sli);
    } else if (state_ == SlaveState::chain_busy && sli) {
      become_idle();
    }
    awaited_ = state_ == SlaveState::data ? static_cast<std::uint8_t>(!ma_) : nothing_awaited;
  }

  constexpr void rise(Picoseconds now, bool sli) {
    switch (state_) {
      case SlaveState::requested:
        latch(now);
        break;
      case SlaveState::latched:
        acknowledge(now);
        break;
      case SlaveState::ack:
        if (may_start(now)) {
          level_ = true;
          state_ = SlaveState::start;
        }
        break;
      case SlaveState::start:
        level_ = source_.cds(chain_.pop());
        if (level_) payload_.cover_cds(codec_);
        state_ = SlaveState::data;
        break;
      case SlaveState::data:
        if (payload_.load() && payload_.next(level_)) break;
        state_ = SlaveState::stop;
        level_ = chain_.pop();
        break;
      case SlaveState::stop:
      case SlaveState::early_request:
        if (paused_) ignore_request(last_edge_);
        level_ = chain_.pop();
        break;
      case SlaveState::chain_busy:
        if (sli) become_idle();
        return;
      case SlaveState::idle:  // MA returns from a CDM that was held
        return;
    }
    arm(now);
  }

  constexpr void fall(Picoseconds now, bool sli) {
    if (state_ == SlaveState::chain_busy && sli) become_idle();
    if (state_ == SlaveState::chain_busy) ignore_request(now);
    if (state_ == SlaveState::idle) {
      begin_request(now);
    } else if (state_ != SlaveState::latched) {
      receive(sli);
      // A pause as long as this counts as a stopped clock: later edges are not part of the frame.
      paused_ = now - last_edge_ > timer_.reference();
    }
    arm(now);
  }

  constexpr void begin_request(Picoseconds now) {
    state_ = SlaveState::requested;
    timer_.begin(timing_, now);
    chain_.clear();
    in_frame_ = channels_active_;
    if (!in_frame_) payload_.clear();
  }

  constexpr void latch(Picoseconds now) {
    state_ = SlaveState::latched;
    ready_at_ = now;
    if (!in_frame_) return;
    ready_at_ = now + timing_.start_min;
    sample_at_ = now + timing_.sampling;
    if (sample_at_ <= now) take_sample();
  }

  constexpr void acknowledge(Picoseconds now) {
    state_ = SlaveState::ack;
    level_ = false;
    cdm_open_ = true;
    if (in_frame_) ready_at_ = std::max(ready_at_, now + timing_.ready);
    ack_clocks_ = 0;
    busy_clocks_ = timing_.busy_s_clocks;
    timer_.measure(timing_, now);
  }

  constexpr bool may_start(Picoseconds now) {
    if (ack_clocks_ < timing_.ack_clocks) ++ack_clocks_;
    if (sample_at_ != never) return false;
    if (timing_.ack_clocks != 0 ? ack_clocks_ < timing_.ack_clocks : now < ready_at_) return false;
    if (timing_.chained && !chain_.started()) return false;
    if (busy_clocks_ == 0) return true;
    --busy_clocks_;
    return false;
  }

  constexpr void receive(bool sli) {
    if (timing_.chained) chain_.receive(sli);
  }

  constexpr void ignore_request(Picoseconds begin) {
    state_ = SlaveState::early_request;
    timer_.restart(timing_, begin);
  }

  constexpr void arm(Picoseconds now) {
    last_edge_ = now;
    release_at_ = timer_.after(now);
    due_ = std::min(release_at_, sample_at_);
  }

  constexpr void expire(Picoseconds now, bool sli) {
    if (sample_at_ <= now && sample_at_ <= release_at_) {
      take_sample();
      due_ = release_at_;
      if (now < due_) return;
    }
    release(sli);
  }

  constexpr void release(bool sli) {
    sample_at_ = never;
    const bool acknowledged = state_ > SlaveState::latched;
    if (cdm_open_) source_.cdm(!ma_);
    cdm_open_ = false;
    if (!timing_.chained || sli || !acknowledged) {
      become_idle();
      return;
    }
    state_ = SlaveState::chain_busy;
    level_ = false;
    due_ = never;
  }

  constexpr void become_idle() {
    state_ = SlaveState::idle;
    level_ = true;
    due_ = never;
  }

  constexpr void take_sample() {
    payload_.take(codec_, source_.sample(sample_at_));
    sample_at_ = never;
  }

  [[no_unique_address]] Codec codec_;
  [[no_unique_address]] Source source_;
  SlaveTiming timing_;
  Picoseconds due_ = never;         // the next thing that happens by itself
  Picoseconds release_at_ = never;  // the end of the frame; kept if a sample is due first
  Picoseconds sample_at_ = never;
  Picoseconds ready_at_{};
  Picoseconds last_edge_{};  // kept up except between data bits
  SlaveState state_ = SlaveState::idle;
  static constexpr std::uint8_t nothing_awaited = 2;
  std::uint8_t awaited_ = nothing_awaited;  // MA's next level in the state data
  bool ma_ = true;                          // MA; in the state data, its inverse is in awaited_
  bool level_ = true;
  bool cdm_open_ = false;  // a frame's CDM is still to come
  bool channels_active_ = true;
  bool in_frame_ = true;  // its channels, in the frame under way
  bool paused_ = false;   // MA had been high too long for a clock
  std::uint8_t busy_clocks_ = 0;
  std::uint16_t ack_clocks_ = 0;
  slave_detail::PayloadBits<Codec> payload_;
  slave_detail::ReleaseTimer timer_;
  [[no_unique_address]] slave_detail::ChainBits<ChainBits> chain_;
};

}  // namespace biss
