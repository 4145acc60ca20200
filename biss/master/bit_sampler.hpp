// SLO of one request, bit by bit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "biss/base/bit_buffer.hpp"
#include "biss/base/units.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/request_setup.hpp"
#include "biss/timing/device_timing.hpp"
#include "biss/timing/step.hpp"

namespace biss {

/// What a sample was.
enum class SampleEvent : std::uint8_t {
  bit,     ///< nothing to do
  ack,     ///< ACK's first 0
  cds,     ///< CDS, which is level(): start_clock() is known
  last,    ///< STOP: bits() are complete
  failed,  ///< cause() says why there will be no more
};

/// Samples SLO once for each rising edge of MA, from the one that makes ACK to STOP's. Sample k
/// belongs to edge k whenever it comes, so the line delay may be any number of periods.
template <std::size_t CapacityBits>
class BitSampler {
 public:
  /// \pre setup's defaults are filled in; START, CDS, payload and STOP fit
  constexpr BitSampler(const MasterSetup& setup, const AckBounds& ack, unsigned payload_bits)
      : period_(setup.period),
        step_(setup.sample_step),
        middle_(setup.period / 2),
        shift_(setup.sample_shift),
        delay_max_(setup.line_delay_max),
        margin_(setup.period / 20),
        ack_(ack),
        payload_bits_(static_cast<std::uint16_t>(payload_bits)),
        compensate_(setup.compensate) {}

  /// When sample() is due.
  constexpr Picoseconds next() const { return next_; }
  constexpr bool level() const { return level_; }
  /// Of the last begin(); as in BasicReading.
  constexpr std::optional<Picoseconds> line_delay() const { return delay_; }
  constexpr std::uint16_t lead_clocks() const { return lead_clocks_; }
  constexpr std::uint16_t ack_clocks() const { return ack_clocks_; }
  constexpr bool marginal() const { return marginal_; }
  /// START, CDS, payload, STOP. \pre `last` was told
  constexpr BitView bits() const { return bits_.view(); }
  /// The rising edge of MA that makes START. \pre `cds` was told
  constexpr std::uint32_t start_clock() const { return start_clock_; }
  /// Nothing, or what is wrong although bits() are complete: ack_range.
  constexpr std::optional<FrameError> cause() const { return cause_; }

  /// A request begins.
  /// \param high_by where SLO is low although the encoder is ready: when it must have been seen to
  ///   rise, and stay high for a period until ACK; `now` where it is high
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

  /// The second rising edge of MA. \return failed where SLO is low already
  constexpr SampleEvent ack_clock(Picoseconds now) {
    if (!level_ && (!began_low_ || high_by_ <= now || !compensate_)) {
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

  /// SLO changed. \return failed where ACK comes too late
  constexpr SampleEvent change(Picoseconds now, bool slo) {
    const Picoseconds lasted = now - last_change_;
    level_ = slo;
    last_change_ = now;
    if (now - last_sample_ <= margin_) marginal_ = true;
    if (slo && state_ == State::rising) wait();
    const bool expected = compensate_ ? state_ == State::waiting : state_ == State::lead;
    if (slo || !expected) return SampleEvent::bit;
    // SLO was low when the request began, and this was no more than a glitch.
    if (began_low_ && lasted < period_) return fail(FrameError::response_range);
    delay_ = now - ack_edge_;
    if (*delay_ > delay_max_) return fail(FrameError::response_range);
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

  /// The next edges of MA come so much later, and so do their bits.
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
    rising,   // SLO shows the end of the cycle before; next_ is how long it may
    waiting,  // for SLO to fall; next_ is how long
    lead,     // for the first 0
    ack,      // for START
    cds,
    payload,
  };

  // Half a period of grace, so that a delay of just the longest is still seen.
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
    // The answer is heard to its end all the same: the encoder is sending.
    if (ack_clocks_ < ack_.min_clocks) cause_ = FrameError::ack_range;
    start_clock_ = std::uint32_t{1} + lead_clocks_ + ack_clocks_;
    left_ = static_cast<std::uint16_t>(2U + payload_bits_);
    state_ = State::cds;
    return SampleEvent::bit;
  }

  constexpr SampleEvent cds_bit() {
    word_ = level_ ? 0b11 : 0b10;  // behind START
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
  // Bits on their way to bits_, which takes up to 34 at once.
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

}  // namespace biss
