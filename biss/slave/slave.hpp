// The encoder's side of the line, as a stepper: MA, SLI and time in, SLO and the next deadline out.
//
//   struct Encoder {
//     BasicFrame<1> sample(Picoseconds moment);  // the channels' values as of that moment
//     bool cds(bool predecessor);                // the CDS bit, asked when it is sent
//     void cdm(bool bit);                        // the CDM bit, told when a frame has ended
//   };
//   Slave slave(codec, slave_timing(device), Encoder{});
//   StepOutput out = slave.step(now, ma, sli);   // at each change of an input, and at out.deadline
//
// After the protocol description D2 and Renishaw's data sheet, without cable and internal delay.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "biss/slave/chain_bits.hpp"
#include "biss/slave/payload_bits.hpp"
#include "biss/slave/release_timer.hpp"
#include "biss/slave/slave_state.hpp"
#include "biss/slave/slave_timing.hpp"
#include "biss/timing/step.hpp"

namespace biss {

/// One slave with the channels of the codec's format.
///
/// `ChainBits` is the memory for a predecessor's bits; 0 spares it where no slave is chained.
template <class Codec, SlaveSource<Codec> Source, std::size_t ChainBits = slave_chain_bits>
class Slave {
 public:
  /// Idle, MA taken for high. \pre timing is not chained where ChainBits is 0
  constexpr Slave(const Codec& codec, const SlaveTiming& timing, Source source)
      : codec_(codec), source_(source), timing_(timing) {}

  /// To be called at each change of `ma` or `sli` and at the deadline; any further call does no
  /// harm. What was due by `now` happens first, so that an edge at the moment of sampling finds the
  /// position taken, and one at the end of the timeout finds the slave idle.
  /// \param now not before the last step's
  /// \param sli of a slave that is not chained: not looked at
  constexpr StepOutput step(Picoseconds now, bool ma, bool sli) {
    if (!step_in_data(now, ma, sli)) step_apart(now, ma, sli);
    return {level_, due_};
  }

  constexpr SlaveState state() const { return state_; }
  constexpr const SlaveTiming& timing() const { return timing_; }
  /// Another behaviour from now on; \pre as for the constructor, and state() is idle
  constexpr void set_timing(const SlaveTiming& timing) { timing_ = timing; }
  /// Whether its channels are in the frame, from the next request on; at first they are. Without
  /// them CDS is followed by STOP or the predecessor's channels, nothing is sampled, and the answer
  /// waits for no position: only clocks of ACK and busy_s that the device always takes remain. May
  /// be called from within the owner's calls.
  constexpr void set_channels_active(bool active) { channels_active_ = active; }
  constexpr bool channels_active() const { return channels_active_; }
  constexpr Source& source() { return source_; }
  constexpr const Codec& codec() const { return codec_; }

 private:
  // Most edges are clocks of data. False: this is none, and nothing was done.
  constexpr bool step_in_data(Picoseconds now, bool ma, bool sli) {
    if (awaited_ != static_cast<std::uint8_t>(ma) || now.count >= due_.count) return false;
    if (ma) {
      if (!payload_.next(level_)) return false;
    } else {
      hear(sli);
    }
    awaited_ = static_cast<std::uint8_t>(!ma);
    timer_.extend(due_, now);
    return true;
  }

  // Apart, so that it takes no registers from step_in_data().
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
      hear(sli);
      // As long as a clock that has stopped: nothing that follows belongs to the frame.
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

  constexpr void hear(bool sli) {
    if (timing_.chained) chain_.hear(sli);
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
  Picoseconds release_at_ = never;  // the end of the frame; kept where a sample is due first
  Picoseconds sample_at_ = never;
  Picoseconds ready_at_{};
  Picoseconds last_edge_{};  // kept up except between data bits
  SlaveState state_ = SlaveState::idle;
  static constexpr std::uint8_t nothing_awaited = 2;
  std::uint8_t awaited_ = nothing_awaited;  // MA's next level in the state data
  bool ma_ = true;                          // MA; in the state data it is the other one
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
