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
  // Kept apart: inlined into one function the evaluations take each other's registers.
  [[gnu::noinline]] static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    return find(plan, decode_frame(bits, plan.codec(), plan.setup().bounds));
  }

  /// The same of what decode_frame() or an SpiReader gave.
  static constexpr SafetyFinding find(const Plan& plan,
                                      const Result<typename Plan::Frame, FrameFault>& frame) {
    if (!frame.ok()) return {.cause = cause_of(plan.setup(), frame.error())};
    const Channel& cpw = frame->channel_list[plan.setup().cpw];
    const Channel& spw = frame->channel_list[plan.setup().spw];
    const std::int32_t apart = difference(plan.alignment(), cpw.position, spw.position);
    return {.position = cpw.position,
            .difference_lsb = apart,
            .life_counter = static_cast<std::uint8_t>(spw.life_counter),
            .cpw_nW = cpw.nW,
            .spw_nW = spw.nW,
            .cause = cause_of(plan.setup(), cpw, spw, apart)};
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

  static constexpr SafetyVerdict cause_of(const SafetySetup& setup, const Channel& cpw,
                                          const Channel& spw, std::int32_t apart) {
    if (!cpw.nE) return SafetyVerdict::cpw_error;
    if (!spw.nE) return SafetyVerdict::spw_error;
    const std::int32_t most = setup.comparison.tolerance_lsb;
    return apart > most || apart < -most ? SafetyVerdict::comparison : SafetyVerdict::safe;
  }

  // The lower bits of the difference, and above them its sign.
  static constexpr std::int32_t difference(const safety_detail::Alignment& alignment,
                                           std::uint64_t cpw, std::uint64_t spw) {
    const std::uint64_t mask = low_mask(alignment.bits);
    const std::uint64_t half = mask ^ (mask >> 1U);
    const std::uint64_t apart = (cpw >> alignment.cpw_shift) - (spw >> alignment.spw_shift);
    return safety_detail::held(static_cast<std::int64_t>(((apart & mask) ^ half) - half),
                               alignment.bits);
  }

  LifeCounter counter_;
};

}  // namespace biss
