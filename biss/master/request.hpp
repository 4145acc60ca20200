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
// STOP. MA stops with that one, or behind CDS where more bits are on their way than are left.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/bit_sampler.hpp"
#include "biss/master/ma_clock.hpp"
#include "biss/master/request_end.hpp"
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
/// because SLO tells nothing then; high, unless all bits came and CDM is 1. A request for no more
/// than CDS ends as a good frame, or as any other where SLO stays at a 1 of a channel.
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

  /// Begins a request: MA falls now, or where CDM is held low it rises and falls `idle_min` later.
  /// Refused while SLO is low, unless ready_by_time(), and before earliest(); then done() stays
  /// true, reading() has the refusal, and the deadline says when to try again.
  /// \pre done(), now is not before the last call
  constexpr StepOutput begin(Picoseconds now, bool slo, bool cdm,
                             RequestKind kind = RequestKind::frame) {
    reading_ = Reading{};
    reading_.begin = now;
    const bool ready = slo || ready_by_time(now);
    sampler_.begin(now, slo, slo ? now : high_by_);
    if (now < earliest_ || !ready) return refuse(ready);
    phase_ = Phase::reading;
    high_by_ = long_ago;
    kind_ = kind;
    clock_.begin(now, cdm, setup_.idle_min);
    if (kind == RequestKind::reduced) clock_.stop_at(2);
    due_ = clock_.next();
    if (clock_.level()) reading_.begin = due_;
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

  /// Another CDM than begin() was told: an answer to reading().cds, which is there as soon as CDS
  /// has come. In time within a quarter of a period after the step that brought it. \pre !done()
  constexpr void set_cdm(bool cdm) { clock_.set_cdm(cdm); }

  /// No request is running.
  constexpr bool done() const { return phase_ == Phase::idle; }
  /// Of the last request, whole when done(); `cds` before.
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
    settling,   // all came that was asked for: until SLO rises
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
    if (now != clock_.next()) be_late(now);
    clock_.edge(now);
    if (phase_ == Phase::stopping) return settle(now);
    if (clock_.level() && clock_.rises() == 2) take(sampler_.ack_clock(now), now);
  }

  constexpr void be_late(Picoseconds now) {
    sampler_.delay_by(now - clock_.next());
    if (clock_.level() && clock_.rises() == 0) reading_.begin = now;
  }

  constexpr void change(Picoseconds now, bool slo) {
    take(sampler_.change(now, slo), now);
    if (phase_ == Phase::settling && slo && now >= quiet_) finish(now);
    schedule();
  }

  constexpr void take(SampleEvent event, Picoseconds now) {
    if (event != SampleEvent::bit) act(event, now);
  }

  [[gnu::noinline, gnu::cold]] constexpr void act(SampleEvent event, Picoseconds now) {
    if (event == SampleEvent::ack && kind_ != RequestKind::reduced) return;
    if (event == SampleEvent::cds) {
      const bool whole = kind_ == RequestKind::frame;
      reading_.cds = sampler_.level();
      const unsigned channels = whole ? codec_.payload_bits() + setup_.extra_clocks : 0U;
      clock_.stop_in_time(sampler_.start_clock() + 2U + channels, now);
      if (whole) return;
    }
    if (event == SampleEvent::failed) clock_.abandon(now);
    sampler_.stop();
    phase_ = Phase::stopping;
    settle(now);
  }

  // Once MA has stopped, what was read is judged.
  constexpr void settle(Picoseconds now) {
    if (clock_.running()) return;
    reading_.clocks = clock_.rises();
    judge(sampler_, kind_, codec_, reading_);
    const Picoseconds travel = reading_.line_delay.value_or(Picoseconds{}) + setup_.period;
    limit_ = reset_end(setup_, reading_.begin, clock_.last_edge(), travel);
    phase_ = Phase::resetting;
    if (kind_ == RequestKind::frame ? !reading_.frame.ok() : sampler_.cause().has_value()) return;
    phase_ = Phase::settling;
    quiet_ = now;
    // SLO ends it, so there is no harm in waiting as long as any encoder may take.
    limit_ = std::max(limit_, clock_.last_edge() + biss_static_timeout_max);
    if (kind_ == RequestKind::control_only) {
      // Bits of the channels may be under way, and the last one stays for the timeout.
      quiet_ = clock_.last_edge() + travel;
      return;
    }
    if (!sampler_.level()) {
      if (knows_ready_time()) limit_ = reading_.begin + setup_.timing.timeout.time;
      return;
    }
    if (clock_.level()) return finish(now);
    limit_ = now + setup_.period / 2;  // ready before CDM was sent; MA may not just twitch
  }

  constexpr bool knows_ready_time() const {
    return clock_.level() && released_by_time(setup_, reading_.begin, clock_.last_edge());
  }

  constexpr void finish(Picoseconds now) {
    if (!setup_.hold_cdm) clock_.release(now);
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
  RequestKind kind_ = RequestKind::frame;
  Picoseconds quiet_{};  // a rise of SLO is a bit until then
  Picoseconds due_ = never;
  Picoseconds limit_ = never;
  Picoseconds earliest_ = long_ago;
  Picoseconds high_by_ = long_ago;  // a request may begin with SLO low before that
  Reading reading_;
};

}  // namespace biss
