// The master's side of the line: one request after the other, as a stepper.
//
//   clock     1       2       3       4       5       6  … the one of STOP
//   MA   ‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾
//             :LAT    :ACK            :START  :CDS
//   SLO  ‾‾‾‾‾‾‾‾‾‾‾‾‾:‾‾\_______________/‾‾‾‾‾‾‾X=======X
//                     |d |T/2|       ^       ^       ^       ^     a sample for each clock
//
// d is measured in each request. Samples are numbered from ACK, so d may be any number of periods:
// they keep coming at their spacing while MA is that much ahead. START tells which clock makes
// STOP. MA stops with that one, or at once where more bits are on their way than the frame still
// has.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/bit_sampler.hpp"
#include "biss/master/ma_clock.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/timing/step.hpp"

namespace biss {

/// Makes requests and reads the answers. Drives MA, is told SLO and the time.
///
///   StepOutput out = master.begin(now, slo);
///   while (!master.done()) out = master.step(now, slo);  // at each change of SLO and each
///   deadline use(master.reading());
///
/// Every request ends by itself, whatever SLO does. After a good frame MA rests as CDM says (0:
/// high, 1: low) until SLO rises, which means ready. After any other it rests for the reset time,
/// because SLO tells nothing then; high, unless all bits came and CDM is 1.
///
/// With MasterSetup::trust_cycle_time, waiting behind a good frame ends when the encoder is known
/// to be ready: by TimeoutRule::cycle, the time since the request began. SLO shows it a line delay
/// later, so done() comes and begin() may be told SLO low (ready_by_time()); so behind a cable,
/// too, requests come as fast as the device allows. SLO must then be seen to rise within the line
/// delay measured before and stay high for a period until ACK. Needs compensation and CDM 0; a
/// frame that outlasts the time waits as ever.
///
/// A sample sees the level from before the time of the call: of a change and a sample at the same
/// instant either may be told first. A call later than the deadline moves that edge of MA and all
/// that follow.
///
/// `Codec` is a FrameCodec or FixedCodec; it is kept by value.
template <class Codec>
class RequestCycle {
 public:
  using Frame = typename Codec::Frame;
  using Reading = BasicReading<Frame>;

  /// \pre setup keeps what MasterSetup asks
  constexpr RequestCycle(const Codec& codec, const MasterSetup& setup)
      : codec_(codec),
        setup_(with_defaults(setup)),
        clock_(setup_.period, setup_.low_time),
        sampler_(setup_, request_ack_bounds(setup_), codec.payload_bits()) {}

  /// With the defaults filled in.
  constexpr const MasterSetup& setup() const { return setup_; }
  constexpr const Codec& codec() const { return codec_; }

  /// Begins a request: MA falls now. Refused while SLO is low, unless ready_by_time(), and before
  /// earliest(); then done() stays true, reading() has the refusal, and the deadline says when to
  /// try again.
  /// \pre done(), now is not before the last call
  constexpr StepOutput begin(Picoseconds now, bool slo, bool cdm) {
    reading_ = Reading{};
    reading_.begin = now;
    const bool ready = slo || ready_by_time(now);
    sampler_.begin(now, slo, slo ? now : high_by_);
    if (now < earliest_ || !ready) return refuse(ready);
    phase_ = Phase::reading;
    high_by_ = long_ago;
    clock_.begin(now, cdm);
    due_ = clock_.next();
    return {clock_.level(), due_};
  }

  /// With the setup's CDM.
  constexpr StepOutput begin(Picoseconds now, bool slo) { return begin(now, slo, setup_.cdm); }

  /// Call at every change of SLO and at the deadline; any other call changes nothing.
  /// \pre now is not before the last call
  constexpr StepOutput step(Picoseconds now, bool slo) {
    if (due_ <= now) happen(now);
    if (slo != sampler_.level()) change(now, slo);
    return {clock_.level(), std::max(due_, now)};
  }

  /// No request is running.
  constexpr bool done() const { return phase_ == Phase::idle; }
  /// Of the last request, whole when done().
  constexpr const Reading& reading() const { return reading_; }
  /// The next request is refused before this time. \pre done()
  constexpr Picoseconds earliest() const { return earliest_; }
  /// The encoder is ready by its fixed cycle time, although SLO may still be seen low. \pre done()
  constexpr bool ready_by_time(Picoseconds now) const { return now < high_by_; }

 private:
  enum class Phase : std::uint8_t {
    idle,
    reading,    // bits are expected
    stopping,   // no more are, but MA has edges to go
    settling,   // a good frame: until SLO rises
    resetting,  // any other
  };

  static constexpr Picoseconds long_ago{std::numeric_limits<std::int64_t>::min()};
  // START, CDS, payload, STOP.
  static constexpr std::size_t capacity_bits =
      3U + max_channel_bits * (sizeof(Frame::channel_list) / sizeof(Channel));

  constexpr void schedule() { due_ = std::min(std::min(clock_.next(), sampler_.next()), limit_); }

  // What is due, in its order.
  constexpr void happen(Picoseconds now) {
    if (sampler_.next() < clock_.next()) take_samples(now);
    if (clock_.next() <= now) edge(now);
    if (sampler_.next() <= now) take_samples(now);
    if (limit_ <= now) finish(now);
    schedule();
  }

  // Those that come before the next edge of MA.
  [[gnu::noinline]] constexpr void take_samples(Picoseconds now) {
    while (sampler_.next() <= now && sampler_.next() < clock_.next()) take(sampler_.sample(), now);
  }

  constexpr StepOutput refuse(bool slo) {
    reading_.frame = failure(FrameFault{FrameError::not_ready});
    reading_.refusal = slo ? Refusal::too_early : Refusal::slo_low;
    reading_.ready = slo;
    return {clock_.level(), slo ? earliest_ : never};
  }

  constexpr void edge(Picoseconds now) {
    if (now != clock_.next()) sampler_.delay_by(now - clock_.next());
    clock_.edge(now);
    if (phase_ == Phase::stopping) return settle(now);
    if (clock_.level() && clock_.rises() == 2) take(sampler_.ack_clock(now), now);
  }

  constexpr void change(Picoseconds now, bool slo) {
    take(sampler_.change(now, slo), now);
    if (phase_ == Phase::settling && slo) finish(now);
    schedule();
  }

  constexpr void take(SampleEvent event, Picoseconds now) {
    if (event == SampleEvent::bit) return;
    if (event == SampleEvent::start) {
      return clock_.stop_at(sampler_.stop_clock() + setup_.extra_clocks);
    }
    if (event == SampleEvent::failed) clock_.abandon();
    phase_ = Phase::stopping;
    settle(now);
  }

  // Once MA has stopped, what was read is judged.
  constexpr void settle(Picoseconds now) {
    if (clock_.running()) return;
    reading_.line_delay = sampler_.line_delay();
    reading_.lead_clocks = sampler_.lead_clocks();
    reading_.ack_clocks = sampler_.ack_clocks();
    reading_.clocks = clock_.rises();
    if (sampler_.cause()) {
      reading_.frame = failure(FrameFault{*sampler_.cause()});
    } else {
      const FrameStart start{0, sampler_.lead_clocks(), sampler_.ack_clocks()};
      reading_.frame = decode_payload(sampler_.bits(), start, codec_);
    }
    limit_ = reset_end();
    phase_ = Phase::resetting;
    if (!reading_.frame.ok()) return;
    phase_ = Phase::settling;
    // SLO ends it, so there is no harm in waiting as long as any encoder may take.
    limit_ = std::max(limit_, clock_.last_edge() + biss_static_timeout_max);
    if (!sampler_.level()) {
      if (knows_ready_time()) limit_ = reading_.begin + setup_.timing.timeout.time;
      return;
    }
    if (clock_.level()) return finish(now);
    limit_ = now + setup_.period / 2;  // ready before CDM was sent; MA may not just twitch
  }

  // Behind a frame that outlasts the time nobody knows when SLO is released: it has to be seen.
  constexpr bool knows_ready_time() const {
    const Timeout& timeout = setup_.timing.timeout;
    return timeout.rule == TimeoutRule::cycle && setup_.trust_cycle_time && setup_.compensate &&
           clock_.level() &&
           reading_.begin + timeout.time >=
               clock_.last_edge() + release_time(timeout, setup_.period);
  }

  constexpr Picoseconds reset_end() const {
    const Picoseconds last = clock_.last_edge();
    const Picoseconds travel = reading_.line_delay.value_or(Picoseconds{}) + setup_.period;
    const Timeout& timeout = setup_.timing.timeout;
    if (setup_.reset_time.count != 0) return last + setup_.reset_time + travel;
    if (timeout.rule == TimeoutRule::cycle) {
      // STOP has to be seen where the frame is longer than the cycle.
      return std::max(reading_.begin + timeout.time, last + release_time(timeout, setup_.period)) +
             travel;
    }
    if (timeout.rule == TimeoutRule::fixed) return last + timeout.time + travel;
    // It depends on a clock that the encoder keeps to itself.
    const Picoseconds adaptive = setup_.period * 3 / 2 + timeout.time;
    return last + std::max(biss_static_timeout_max, adaptive) + travel;
  }

  constexpr void finish(Picoseconds now) {
    clock_.release(now);
    limit_ = never;
    if (phase_ == Phase::settling && !sampler_.level() && knows_ready_time()) {
      // Half a period of grace leaves SLO high for a period until ACK.
      high_by_ =
          reading_.begin + setup_.timing.timeout.time + *reading_.line_delay + setup_.period / 2;
    }
    reading_.ready = sampler_.level() || ready_by_time(now);
    reading_.marginal = sampler_.marginal();
    earliest_ =
        std::max(reading_.begin + setup_.timing.cycle_min, clock_.last_edge() + setup_.idle_min);
    phase_ = Phase::idle;
  }

  Codec codec_;
  MasterSetup setup_;
  MaClock clock_;
  BitSampler<capacity_bits> sampler_;
  Phase phase_ = Phase::idle;
  Picoseconds due_ = never;
  Picoseconds limit_ = never;
  Picoseconds earliest_ = long_ago;
  Picoseconds high_by_ = long_ago;  // a request may begin with SLO low before that
  Reading reading_;
};

}  // namespace biss
