// The first of a frame's two evaluations: the frame as decode_frame() reads it, its CRCs from
// tables.
#pragma once

#include <cstdint>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/frame/decode.hpp"
#include "biss/safety/judgement.hpp"
#include "biss/safety/life_counter.hpp"
#include "biss/safety/plan.hpp"

namespace biss {

/// Fields by shift and mask, the comparison modulo the range, the counter by the distance from the
/// last value.
template <class Plan>
class FieldEvaluation {
 public:
  constexpr explicit FieldEvaluation(const SafetySetup& setup) : counter_(setup.counter.mode) {}

  /// \param bits SLO once a MA clock, as for find_start()
  static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    return find(plan, decode_frame(bits, plan.codec(), plan.setup().bounds));
  }

  /// The same of what decode_frame() or an SpiReader gave.
  static constexpr SafetyFinding find(const Plan& plan,
                                      const Result<typename Plan::Frame, FrameFault>& frame) {
    SafetyFinding finding;
    if (!frame.ok()) {
      finding.cause = cause_of(plan.setup(), frame.error());
      return finding;
    }
    const Channel& cpw = frame->channel_list[plan.setup().cpw];
    const Channel& spw = frame->channel_list[plan.setup().spw];
    finding.position = cpw.position;
    finding.life_counter = static_cast<std::uint8_t>(spw.life_counter);
    finding.cpw_nW = cpw.nW;
    finding.spw_nW = spw.nW;
    finding.difference_lsb = difference(plan.alignment(), cpw.position, spw.position);
    finding.cause = SafetyVerdict::safe;
    if (!cpw.nE) {
      finding.cause = SafetyVerdict::cpw_error;
    } else if (!spw.nE) {
      finding.cause = SafetyVerdict::spw_error;
    } else if (const std::int64_t most = plan.setup().comparison.tolerance_lsb;
               finding.difference_lsb > most || finding.difference_lsb < -most) {
      finding.cause = SafetyVerdict::comparison;
    }
    return finding;
  }

  constexpr SafetyVerdict judge_counter(std::uint8_t value, unsigned missed,
                                        const SafetySetup& setup) const {
    return counter_.judge(value, missed, setup.counter);
  }
  constexpr void accept_counter(std::uint8_t value, unsigned missed, const SafetySetup& setup) {
    counter_.accept(value, missed, setup.counter.learn_rollovers);
  }
  constexpr void lose_place() { counter_.lose_place(); }
  constexpr std::optional<CounterMode> counter_mode() const { return counter_.mode(); }

 private:
  static constexpr SafetyVerdict cause_of(const SafetySetup& setup, const FrameFault& fault) {
    if (fault.cause != FrameError::crc) return SafetyVerdict::no_frame;
    if (fault.channel == setup.cpw) return SafetyVerdict::cpw_crc;
    if (fault.channel == setup.spw) return SafetyVerdict::spw_crc;
    return SafetyVerdict::no_frame;
  }

  // The lower bits of the difference, and above them its sign.
  static constexpr std::int64_t difference(const safety_detail::Alignment& alignment,
                                           std::uint64_t cpw, std::uint64_t spw) {
    const std::uint64_t mask = low_mask(alignment.bits);
    const std::uint64_t half = mask ^ (mask >> 1U);
    const std::uint64_t apart = (cpw >> alignment.cpw_shift) - (spw >> alignment.spw_shift);
    return static_cast<std::int64_t>(((apart & mask) ^ half) - half);
  }

  LifeCounter counter_;
};

}  // namespace biss
