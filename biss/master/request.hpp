// The master's side of the line: one request after the other, as a stepper.
//
//   clock     1       2       3       4       5       6  … the one of STOP
//   MA   ‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾\___/‾‾‾
//             :LAT    :ACK            :START  :CDS
//   SLO  ‾‾‾‾‾‾‾‾‾‾‾‾‾:‾‾\_______________/‾‾‾‾‾‾‾X=======X
//                     |d |T/2|       ^       ^       ^       ^     a sample for each clock
//
// The delay d is measured in each request. Samples are numbered from ACK, so d may be any number of
// periods: samples continue at their spacing while MA is ahead by d. START determines which clock
// makes STOP. MA stops with that clock, or after CDS if more bits are already on their way than
// remain.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/result.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/decode.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/cycle.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/timing/step.hpp"

namespace biss {

// ---- MA of one request

/// MA of one request: falls immediately, or rises first if CDM was held low; runs until the edge
/// that stop_at() sets; rests at the level of CDM. Each edge is timed from the previous one, so a
/// late edge delays all later edges and no clock is shortened.
class MaClock {
 public:
  /// \pre low_time is above 0 and below period
  constexpr MaClock(Picoseconds period, Picoseconds low_time)
      : low_(low_time), high_(period - low_time) {}

  constexpr bool level() const { return level_; }
  /// When edge() is due; never: MA rests.
  constexpr Picoseconds next() const { return next_; }
  constexpr bool running() const { return next_ != never; }
  constexpr Picoseconds last_edge() const { return last_edge_; }
  /// Rising edges since begin(), without release().
  constexpr std::uint32_t rises() const { return rises_; }

  /// MA falls; if it is low, it rises first and falls `rest` later. \pre not running()
  constexpr void begin(Picoseconds now, bool cdm, Picoseconds rest) {
    const bool held = !level_;
    release(now);
    cdm_ = cdm;
    rises_ = 0;
    last_rise_ = std::numeric_limits<std::uint32_t>::max();
    next_ = now + rest;
    if (!held) edge(now);
  }

  /// The edge that is due. \pre running()
  constexpr void edge(Picoseconds now) {
    level_ = !level_;
    last_edge_ = now;
    if (level_) {
      ++rises_;
      next_ = rises_ < last_rise_ || cdm_ ? now + high_ : never;
    } else {
      next_ = rises_ < last_rise_ ? now + low_ : never;
    }
  }

  /// MA stops with that rising edge, or as soon as possible if that edge has passed; for CDM 1 it
  /// falls once more.
  constexpr void stop_at(std::uint32_t rise) {
    last_rise_ = rise;
    if (rises_ >= rise && level_ && !cdm_) next_ = never;
  }

  /// Like stop_at(), but not before set_cdm() can act: a quarter of a period.
  constexpr void stop_in_time(std::uint32_t rise, Picoseconds now) {
    const bool soon = !level_ && next_ - now < low_ / 2;
    stop_at(std::max(rise, rises_ + (soon ? 2U : 1U)));
  }

  /// The level at which MA rests, until it has stopped.
  constexpr void set_cdm(bool cdm) { cdm_ = cdm; }

  /// MA stops as soon as possible, high.
  constexpr void abandon(Picoseconds now) {
    cdm_ = false;
    stop_at(0);
    if (!running()) release(now);
  }

  /// MA rises if CDM kept it low; this edge does not count as a clock. \pre not running()
  constexpr void release(Picoseconds now) {
    if (level_) return;
    level_ = true;
    last_edge_ = now;
  }

 private:
  Picoseconds low_;
  Picoseconds high_;
  Picoseconds next_ = never;
  Picoseconds last_edge_{};
  std::uint32_t rises_ = 0;
  std::uint32_t last_rise_ = 0;
  bool level_ = true;
  bool cdm_ = false;
};

// ---- SLO of one request, bit by bit

/// The result of a sample.
enum class SampleEvent : std::uint8_t {
  bit,     ///< nothing to do
  ack,     ///< ACK's first 0
  cds,     ///< CDS, which is level(): start_clock() is known
  last,    ///< STOP: bits() are complete
  failed,  ///< no further samples follow: cause() is the reason
};

/// Samples SLO once for each rising edge of MA, from the edge of ACK to the edge of STOP. Sample k
/// belongs to edge k whenever it is taken, so the line delay may be any number of periods.
template <std::size_t CapacityBits>
class BitSampler {
 public:
  /// \pre the defaults of `chosen` are filled in; START, CDS, payload and STOP fit
  constexpr BitSampler(const MasterSetup& chosen, const AckBounds& ack, unsigned payload_bits)
      : period_(chosen.period),
        step_(chosen.sample_step),
        middle_(chosen.period / 2),
        shift_(chosen.sample_shift),
        delay_max_(chosen.line_delay_max),
        margin_(chosen.period / 20),
        ack_(ack),
        payload_bits_(static_cast<std::uint16_t>(payload_bits)),
        compensate_(chosen.compensate) {}

  /// When sample() must be called.
  constexpr Picoseconds next() const { return next_; }
  constexpr bool level() const { return level_; }
  /// The line delay measured since the last begin(), as in BasicReading.
  constexpr std::optional<Picoseconds> line_delay() const { return delay_; }
  constexpr std::uint16_t lead_clocks() const { return lead_clocks_; }
  constexpr std::uint16_t ack_clocks() const { return ack_clocks_; }
  constexpr bool marginal() const { return marginal_; }
  /// START, CDS, payload, STOP. \pre `last` was returned
  constexpr BitView bits() const { return bits_.view(); }
  /// The rising edge of MA that makes START. \pre `cds` was returned
  constexpr std::uint32_t start_clock() const { return start_clock_; }
  /// Empty, or the cause if bits() are complete but wrong: ack_range.
  constexpr std::optional<FrameError> cause() const { return cause_; }

  /// Begins a request.
  /// \param high_by if SLO is low although the encoder is ready: the time by which SLO must rise,
  ///   and stay high for a period until ACK; `now` if SLO is high
  constexpr void begin(Picoseconds now, bool slo, Picoseconds high_by) {
    level_ = slo;
    high_by_ = high_by;
    began_low_ = high_by > now;
    state_ = State::quiet;
    next_ = never;
    last_change_ = last_sample_ = now - period_;
    delay_.reset();
    cause_.reset();
    lead_clocks_ = ack_clocks_ = 0;
    marginal_ = false;
    bits_.clear();
  }

  /// The second rising edge of MA. \return failed if SLO is already low
  constexpr SampleEvent ack_clock(Picoseconds now) {
    const bool may_rise = began_low_ && high_by_ > now && compensate_;
    if (!level_ && !may_rise && !is_response_delay(last_change_ - now, {}, delay_max_)) {
      return fail(FrameError::response_range);
    }
    ack_edge_ = now;
    lead_clocks_ = 1;
    if (!level_) {
      state_ = State::rising;
      next_ = high_by_;
    } else if (compensate_) {
      wait();
    } else {
      state_ = State::lead;
      next_ = now + middle_ + shift_;
    }
    return SampleEvent::bit;
  }

  /// SLO changed. \return failed if ACK comes too late
  constexpr SampleEvent change(Picoseconds now, bool slo) {
    const Picoseconds lasted = now - last_change_;
    level_ = slo;
    last_change_ = now;
    if (now - last_sample_ <= margin_) marginal_ = true;
    if (slo && state_ == State::rising) wait();
    const bool expected = compensate_ ? state_ == State::waiting : state_ == State::lead;
    if (slo || !expected) return SampleEvent::bit;
    // SLO was low when the request began, and this high pulse was only a glitch.
    if (began_low_ && lasted < period_) return fail(FrameError::response_range);
    delay_ = now - ack_edge_;
    if (!is_response_delay(*delay_, {}, delay_max_)) return fail(FrameError::response_range);
    if (compensate_) {
      state_ = State::lead;
      next_ = ack_edge_ + on_grid(*delay_ + middle_) + shift_;
    }
    return SampleEvent::bit;
  }

  /// Takes the sample that is due.
  constexpr SampleEvent sample() {
    if (state_ == State::rising) return fail(FrameError::response_range);
    if (state_ == State::waiting) return fail(FrameError::no_response);
    if (next_ - last_change_ <= margin_) marginal_ = true;
    last_sample_ = next_;
    next_ += period_;
    switch (state_) {
      case State::payload:
        return payload_bit();
      case State::ack:
        return ack_bit();
      case State::cds:
        return cds_bit();
      default:
        return lead_bit();
    }
  }

  /// The next edges of MA, and so their bits, are `late` later.
  constexpr void delay_by(Picoseconds late) {
    if (next_ != never) next_ += late;
  }

  constexpr void stop() {
    state_ = State::quiet;
    next_ = never;
  }

 private:
  enum class State : std::uint8_t {
    quiet,    // nothing is expected
    rising,   // SLO shows the end of the previous cycle; next_ is how long it may
    waiting,  // for SLO to fall; next_ is how long
    lead,     // for the first 0
    ack,      // for START
    cds,
    payload,
  };

  // Half a period more, so that a delay of exactly the longest is accepted.
  constexpr Picoseconds answer_limit() const { return ack_edge_ + delay_max_ + middle_; }

  constexpr void wait() {
    state_ = State::waiting;
    next_ = answer_limit();
  }

  constexpr Picoseconds on_grid(Picoseconds time) const {
    return step_ * ((time.count + step_.count / 2) / step_.count);
  }

  constexpr SampleEvent lead_bit() {
    if (!level_) {
      ack_clocks_ = 1;
      state_ = State::ack;
      return SampleEvent::ack;
    }
    delay_.reset();
    if (compensate_) {
      wait();  // it was a glitch: ACK lasts a clock at least
      return SampleEvent::bit;
    }
    if (last_sample_ > answer_limit()) return fail(FrameError::no_response);
    ++lead_clocks_;
    return SampleEvent::bit;
  }

  constexpr SampleEvent ack_bit() {
    if (!level_) {
      if (ack_clocks_ >= ack_.max_clocks) return fail(FrameError::no_start);
      ++ack_clocks_;
      return SampleEvent::bit;
    }
    // The answer is still received to its end: the encoder is sending.
    if (ack_clocks_ < ack_.min_clocks) cause_ = FrameError::ack_range;
    start_clock_ = std::uint32_t{1} + lead_clocks_ + ack_clocks_;
    left_ = static_cast<std::uint16_t>(2U + payload_bits_);
    state_ = State::cds;
    return SampleEvent::bit;
  }

  constexpr SampleEvent cds_bit() {
    word_ = level_ ? 0b11 : 0b10;  // after START
    --left_;
    state_ = State::payload;
    return SampleEvent::cds;
  }

  constexpr SampleEvent payload_bit() {
    word_ = word_ * 2U + (level_ ? 1U : 0U);
    --left_;
    if (left_ % 32U != 0) return SampleEvent::bit;
    const std::size_t all = 3U + payload_bits_;
    bits_.append(word_, static_cast<unsigned>(all - left_ - bits_.size_bits()));
    if (left_ != 0) return SampleEvent::bit;
    stop();
    return SampleEvent::last;
  }

  constexpr SampleEvent fail(FrameError cause) {
    cause_ = cause;
    stop();
    return SampleEvent::failed;
  }

  Picoseconds period_;
  Picoseconds step_;
  Picoseconds middle_;
  Picoseconds shift_;
  Picoseconds delay_max_;
  Picoseconds margin_;
  AckBounds ack_;
  std::uint16_t payload_bits_;
  bool compensate_;

  State state_ = State::quiet;
  bool level_ = true;  // until now
  bool marginal_ = false;
  std::uint16_t lead_clocks_ = 0;
  std::uint16_t ack_clocks_ = 0;
  std::uint16_t left_ = 0;  // bits of the payload to come
  std::uint32_t start_clock_ = 0;
  // Bits on their way to bits_, which takes up to 34 per call.
  std::uint64_t word_ = 0;
  Picoseconds next_ = never;
  Picoseconds ack_edge_{};
  Picoseconds high_by_{};
  bool began_low_ = false;
  Picoseconds last_change_{};
  Picoseconds last_sample_{};
  std::optional<Picoseconds> delay_;
  std::optional<FrameError> cause_;
  BitBuffer<CapacityBits> bits_;
};

/// Makes requests and reads the answers. It drives MA; the caller passes SLO and the time.
///
///   StepOutput out = master.begin(now, slo);
///   while (!master.done()) {
///     wait_until(out.deadline);  // or until SLO changes
///     out = master.step(now, slo);
///   }
///   use(master.reading());
///
/// Every request ends, with any levels of SLO. After a good frame, MA rests at the level of CDM (0:
/// high, 1: low) until SLO rises, which means ready. After any other, SLO has no meaning and MA
/// rests until the full request cycle would have ended: high, unless all bits were received and CDM
/// is 1. A request that ends after CDS ends like a good frame, or like a failed one if SLO stays at
/// 1 for a bit of a channel; with TimeoutRule::cycle the next request is refused until the full
/// cycle has ended.
///
/// With MasterSetup::trust_cycle_time, waiting after a good frame ends when the encoder is known to
/// be ready: by TimeoutRule::cycle, a fixed time after the request began. SLO rises a line delay
/// later, so done() may be true, and begin() may be called, while SLO is low (ready_by_time()).
/// Requests then come as fast as the device allows, with any cable. SLO must rise within the line
/// delay measured before and stay high for a period until ACK. This needs compensation and CDM 0; a
/// frame that is longer than the time waits for SLO.
///
/// A sample sees the level from before the time of the call: a change and a sample at the same time
/// may be reported in either order. A call later than the deadline delays that edge of MA and all
/// that follow.
///
/// `Codec` is a FrameCodec or FixedCodec; it is kept by value.
template <class Codec>
class RequestCycle {
 public:
  using Frame = typename Codec::Frame;
  using Reading = BasicReading<Frame>;

  /// A clock above the device's limit, a position without nE and a channel without CRC are errors
  /// unless the setup permits them. A constant object with an error does not compile; any other has
  /// error().
  /// \pre setup meets the conditions of MasterSetup
  constexpr RequestCycle(const Codec& codec, const MasterSetup& setup)
      : codec_(codec),
        setup_(with_defaults(setup)),
        clock_(setup_.period, setup_.low_time),
        sampler_(setup_, request_ack_bounds(setup_), codec.payload_bits()),
        full_cycle_(full_cycle(setup_, codec.payload_bits())),
        error_(check_spi(codec.format(),
                         {.period = setup.period,
                          .no_error_flag = setup.no_error_flag,
                          .unchecked = setup.unchecked},
                         setup.timing)) {
    if (std::is_constant_evaluated() && error_) spi_detail::stop_the_build(*error_);
  }

  /// Why every request is refused; nothing if the master can be used.
  constexpr const std::optional<SpiSetupError>& error() const { return error_; }
  /// The setup with its defaults filled in.
  constexpr const MasterSetup& setup() const { return setup_; }
  constexpr const Codec& codec() const { return codec_; }

  /// Begins a request: MA falls now; if CDM holds it low, MA rises now and falls `idle_min` later.
  /// It is refused while SLO is low, unless ready_by_time(), and before earliest(); then done()
  /// stays true, reading() has the refusal, and the deadline is the time of the next try.
  /// \pre done(), now is not before the last call
  constexpr StepOutput begin(Picoseconds now, bool slo, bool cdm,
                             RequestKind kind = RequestKind::frame) {
    reading_ = Reading{};
    reading_.begin = now;
    const bool ready = slo || ready_by_time(now);
    sampler_.begin(now, slo, slo ? now : high_by_);
    if (error_) return refuse(Refusal::setup);
    if (!ready) return refuse(Refusal::slo_low);
    if (now < earliest_) return refuse(Refusal::too_early);
    phase_ = Phase::reading;
    high_by_ = long_ago;
    cycle_end_ = now + full_cycle_;
    kind_ = kind;
    clock_.begin(now, cdm, setup_.idle_min);
    if (kind == RequestKind::reduced) clock_.stop_at(2);
    due_ = clock_.next();
    if (clock_.level()) {
      reading_.begin = due_;
      cycle_end_ += setup_.idle_min;
    }
    return {clock_.level(), due_};
  }

  /// With the setup's CDM.
  constexpr StepOutput begin(Picoseconds now, bool slo) { return begin(now, slo, setup_.cdm); }

  /// Call it at every change of SLO and at the deadline; further calls change nothing.
  /// \pre now is not before the last call
  constexpr StepOutput step(Picoseconds now, bool slo) {
    if (due_ <= now) happen(now);
    if (slo != sampler_.level()) change(now, slo);
    return {clock_.level(), std::max(due_, now)};
  }

  /// Replaces the CDM that begin() was given, as an answer to reading().cds, which is available as
  /// soon as CDS has come. It takes effect within a quarter of a period after the step that brought
  /// CDS. \pre !done()
  constexpr void set_cdm(bool cdm) { clock_.set_cdm(cdm); }

  /// No request is running.
  constexpr bool done() const { return phase_ == Phase::idle; }
  /// The reading of the last request, complete when done(); `cds` earlier.
  constexpr const Reading& reading() const { return reading_; }
  /// The next request is refused before this time. \pre done()
  constexpr Picoseconds earliest() const { return earliest_; }
  /// The encoder is ready by its fixed cycle time, although SLO may still be low. \pre done()
  constexpr bool ready_by_time(Picoseconds now) const { return now < high_by_; }

 private:
  enum class Phase : std::uint8_t {
    idle,
    reading,    // bits are expected
    stopping,   // none are, but MA still has edges to make
    settling,   // all requested bits came; waits until SLO rises
    resetting,  // any other
  };

  static constexpr Picoseconds long_ago{std::numeric_limits<std::int64_t>::min()};
  // START, CDS, payload, STOP.
  static constexpr std::size_t capacity_bits =
      3U + max_channel_bits * (sizeof(Frame::channel_list) / sizeof(Channel));

  // From the start of a request until the device is ready again, if the master sends every clock
  // and ACK takes its longest (CycleBudget), without line delay.
  static constexpr Picoseconds full_cycle(const MasterSetup& setup, unsigned payload_bits) {
    const FrameLength length{payload_bits + setup.busy_s_clocks, setup.slaves};
    const CycleBudget budget = cycle_budget_of(length, setup.timing, setup.period, {});
    return budget.total - budget.idle;
  }

  constexpr void schedule() { due_ = std::min(std::min(clock_.next(), sampler_.next()), limit_); }

  // Does everything that is due, in order of time.
  constexpr void happen(Picoseconds now) {
    if (sampler_.next() < clock_.next()) take_samples(now);
    if (clock_.next() <= now) edge(now);
    if (sampler_.next() <= now) take_samples(now);
    if (limit_ <= now) finish(now);
    schedule();
  }

  // Takes the samples before the next edge of MA.
  [[gnu::noinline]] constexpr void take_samples(Picoseconds now) {
    while (sampler_.next() <= now && sampler_.next() < clock_.next()) take(sampler_.sample(), now);
  }

  constexpr StepOutput refuse(Refusal why) {
    reading_.frame = failure(FrameFault{FrameError::not_ready});
    reading_.refusal = why;
    reading_.ready = why == Refusal::too_early;
    return {clock_.level(), reading_.ready ? earliest_ : never};
  }

  constexpr void edge(Picoseconds now) {
    if (now != clock_.next()) be_late(now);
    clock_.edge(now);
    if (phase_ == Phase::stopping) return settle(now);
    if (clock_.level() && clock_.rises() == 2) take(sampler_.ack_clock(now), now);
  }

  constexpr void be_late(Picoseconds now) {
    sampler_.delay_by(now - clock_.next());
    cycle_end_ += now - clock_.next();
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

  // Evaluates the received bits, once MA has stopped.
  constexpr void settle(Picoseconds now) {
    if (clock_.running()) return;
    reading_.clocks = clock_.rises();
    judge();
    const Picoseconds travel = reading_.line_delay.value_or(Picoseconds{}) + setup_.period;
    limit_ = reset_end() + travel;
    phase_ = Phase::resetting;
    if (kind_ == RequestKind::frame ? !reading_.frame.ok() : sampler_.cause().has_value()) return;
    phase_ = Phase::settling;
    quiet_ = now;
    // Such a device treats a request that ends early as a reset, for any SLO.
    if (kind_ != RequestKind::frame && setup_.timing.timeout.rule == TimeoutRule::cycle) {
      earliest_ = limit_;
    }
    // SLO ends the wait, so it may be as long as any encoder takes.
    limit_ = std::max(limit_, clock_.last_edge() + biss_static_timeout_max);
    if (kind_ == RequestKind::control_only) {
      // Bits of the channels may be on their way, and the last one stays for the timeout.
      quiet_ = clock_.last_edge() + travel;
      return;
    }
    if (!sampler_.level()) {
      if (knows_ready_time()) limit_ = reading_.begin + setup_.timing.timeout.time;
      return;
    }
    if (clock_.level()) return finish(now);
    limit_ = now + setup_.period / 2;  // ready before CDM was sent; CDM needs half a period
  }

  // Fills in the data that the stopped sampler received.
  constexpr void judge() {
    reading_.line_delay = sampler_.line_delay();
    reading_.lead_clocks = sampler_.lead_clocks();
    reading_.ack_clocks = sampler_.ack_clocks();
    if (sampler_.cause()) {
      reading_.frame = failure(FrameFault{*sampler_.cause()});
    } else if (kind_ != RequestKind::frame) {
      reading_.frame = failure(FrameFault{FrameError::truncated});
    } else {
      const FrameStart start{0, reading_.lead_clocks, reading_.ack_clocks};
      reading_.frame = decode_payload(sampler_.bits(), start, codec_);
    }
  }

  // The end of the idle time of MA after a failed request, at the device. Renishaw's data sheet
  // asks for MA high "for the remaining duration of the full request cycle, including timeout", and
  // SLO may have any level until then. Other devices end an incomplete frame one timeout after the
  // last edge (D2). The last edge that they received is unknown, so the master also waits one
  // timeout after its own last edge.
  constexpr Picoseconds reset_end() const {
    const Timeout& timeout = setup_.timing.timeout;
    if (setup_.reset_time.count != 0) return clock_.last_edge() + setup_.reset_time;
    Picoseconds rest = timeout.time;
    // STOP must be seen if the frame is longer than the cycle.
    if (timeout.rule == TimeoutRule::cycle) rest = release_time(timeout, setup_.period);
    // It depends on the encoder's internal clock.
    if (timeout.rule == TimeoutRule::adaptive) {
      rest = std::max(biss_static_timeout_max, setup_.period * 3 / 2 + timeout.time);
    }
    return std::max(cycle_end_, clock_.last_edge() + rest);
  }

  // Whether the device is ready a known time after the request began. After a frame that is longer
  // than this time, the moment when SLO is released is unknown and must be observed.
  constexpr bool knows_ready_time() const {
    const Timeout& timeout = setup_.timing.timeout;
    return timeout.rule == TimeoutRule::cycle && setup_.trust_cycle_time && setup_.compensate &&
           clock_.level() &&
           reading_.begin + timeout.time >=
               clock_.last_edge() + release_time(timeout, setup_.period);
  }

  constexpr void finish(Picoseconds now) {
    if (!setup_.hold_cdm) clock_.release(now);
    limit_ = never;
    if (phase_ == Phase::settling && !sampler_.level() && knows_ready_time()) {
      // Half a period more keeps SLO high for a period until ACK.
      high_by_ =
          reading_.begin + setup_.timing.timeout.time + *reading_.line_delay + setup_.period / 2;
    }
    reading_.ready = sampler_.level() || ready_by_time(now);
    reading_.marginal = sampler_.marginal();
    earliest_ = std::max({earliest_, reading_.begin + setup_.timing.cycle_min,
                          clock_.last_edge() + setup_.idle_min});
    phase_ = Phase::idle;
  }

  Codec codec_;
  MasterSetup setup_;
  MaClock clock_;
  BitSampler<capacity_bits> sampler_;
  Picoseconds full_cycle_;
  std::optional<SpiSetupError> error_;
  Picoseconds cycle_end_{};  // of the request under way, if it were complete
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
