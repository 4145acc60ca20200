// The first of the two evaluations of a frame: the frame as decode_frame() decodes it, its CRCs
// from tables.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/base/bits.hpp"
#include "biss/base/result.hpp"
#include "biss/frame/decode.hpp"
#include "biss/safety/plan.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"

namespace biss {

// ---- The sign-of-life counter

/// Compares the sign-of-life counter with the expected value, names the cause if it differs, and
/// learns the counter's range.
class LifeCounter {
 public:
  constexpr explicit LifeCounter(CounterMode mode)
      : first_(mode == CounterMode::count_1_63   ? 1
               : mode == CounterMode::count_0_63 ? 0
                                                 : unknown) {}

  /// The next value starts a new sequence. The known range stays.
  constexpr void lose_place() {
    last_ = none;
    rollovers_ = 0;
  }

  /// Whether this value may come next.
  /// \param value 0…63
  /// \param missed frames that were not accepted since the last accepted one
  /// \return safe, or one of the counter_ causes
  constexpr SafetyVerdict judge(std::uint8_t value, unsigned missed,
                                const SafetyCounter& setup) const {
    // The usual case.
    if (missed == 0 && value == last_ + 1U) return SafetyVerdict::safe;
    if (last_ == none) {
      return first_ == 1 && value == 0 ? SafetyVerdict::counter_mode : SafetyVerdict::safe;
    }
    if (fits(value, missed, setup.missed, first_of(value))) return SafetyVerdict::safe;
    if (value == last_) return SafetyVerdict::counter_repeated;
    // While the range is being learned, no value fits this one.
    const unsigned other_first = 1U - first_;
    if (confirmed_ == 0 && fits(value, missed, setup.missed, other_first)) {
      return SafetyVerdict::counter_mode;
    }
    return cause_of(value, missed, setup.near_frames);
  }

  /// Takes a value that was judged safe.
  constexpr void accept(std::uint8_t value, unsigned missed, std::uint8_t learn_rollovers) {
    if (last_ == highest && missed == 0) {
      if (first_ == unknown) {
        rollovers_ = value == candidate_ ? static_cast<std::uint8_t>(rollovers_ + 1U) : 1;
        candidate_ = value;
        if (rollovers_ >= learn_rollovers) first_ = value;
      }
      confirmed_ = first_ != unknown ? 1 : 0;
    }
    last_ = value;
  }

  /// The range that the device uses: from the setup, or learned; none while it is unknown.
  constexpr std::optional<CounterMode> mode() const {
    if (first_ == unknown) return std::nullopt;
    return first_ == 1 ? CounterMode::count_1_63 : CounterMode::count_0_63;
  }

 private:
  static constexpr std::uint8_t unknown = 2;
  static constexpr std::uint8_t highest = 63;
  static constexpr std::uint8_t none = 0xFF;

  // The lowest value of the expected range. While it is being learned, the counter may roll over to
  // 0 or to 1.
  constexpr unsigned first_of(std::uint8_t value) const {
    if (first_ != unknown) return first_;
    return value == 1 ? 1 : 0;
  }

  // Frames from the last value to this one, 0 for the same.
  constexpr unsigned ahead(unsigned value, unsigned first) const {
    return value >= last_ ? value - last_ : value + 64U - first - last_;
  }

  constexpr bool fits(std::uint8_t value, unsigned missed, MissedFrames rule,
                      unsigned first) const {
    if (value < first) return false;
    const unsigned frames = ahead(value, first);
    const unsigned least = rule == MissedFrames::perhaps ? 1 : missed + 1U;
    return frames >= least && frames <= missed + 1U;
  }

  constexpr SafetyVerdict cause_of(std::uint8_t value, unsigned missed, unsigned near) const {
    const unsigned first = first_of(value);
    if (value < first) return SafetyVerdict::counter_foreign;
    const unsigned frames = ahead(value, first);
    if (frames <= missed) return SafetyVerdict::counter_backwards;
    if (frames <= missed + 1U + near) return SafetyVerdict::counter_skipped;
    const unsigned back = 64U - first - frames;
    return back <= near ? SafetyVerdict::counter_backwards : SafetyVerdict::counter_foreign;
  }

  std::uint8_t first_;
  std::uint8_t last_ = none;
  std::uint8_t candidate_ = unknown;
  std::uint8_t rollovers_ = 0;
  // Not bool: after a fault of the memory it still has a value.
  std::uint8_t confirmed_ = 0;
};

/// Reads fields by shift and mask, compares modulo the range, checks the counter by the distance
/// from its last value.
template <class Plan>
class FieldEvaluation {
 public:
  constexpr explicit FieldEvaluation(const SafetySetup& chosen) : counter_(chosen.counter.mode) {}

  /// \param bits SLO once a MA clock, as for find_start()
  // Not inlined: in one function the two evaluations compete for registers.
  [[gnu::noinline]] static constexpr SafetyFinding find(const Plan& plan, const BitView& bits) {
    return finding_of(plan, decode_frame(bits, plan.codec(), plan.setup().bounds));
  }

  /// The same for the result of decode_frame() or an SpiReader for these bits, with any bounds.
  static constexpr SafetyFinding find(const Plan& plan, const BitView& bits,
                                      const Result<typename Plan::Frame, FrameFault>& frame) {
    if (!find_start(bits, plan.setup().bounds).ok()) return {.cause = SafetyVerdict::no_frame};
    return finding_of(plan, frame);
  }

  /// The position of a finding whose cause is safe, by masks and shifts.
  static constexpr SafePosition safe_position(const Plan& plan, const SafetyFinding& finding) {
    const safety_detail::Alignment& alignment = plan.alignment();
    const std::uint64_t tolerance = plan.setup().comparison.tolerance_lsb;
    const std::uint64_t mask = low_mask(alignment.bits);
    const std::uint64_t key = finding.spw_position >> alignment.spw_shift;
    const unsigned cpw_bits = alignment.bits + alignment.cpw_shift;
    const std::uint64_t value =
        finding.spw_position & low_mask(alignment.bits + alignment.spw_shift);
    const std::uint64_t aligned = safety_detail::in_cpw_counts(plan, value);
    const std::uint64_t half = std::uint64_t{1} << (cpw_bits - 1U);
    const std::uint64_t apart = (finding.cpw_position - aligned) & low_mask(cpw_bits);
    return {
        .value = value,
        .low = ((key - tolerance) & mask) << alignment.spw_shift,
        .high = (((key + tolerance) & mask) << alignment.spw_shift) | low_mask(alignment.spw_shift),
        .cpw_only_offset = static_cast<std::int64_t>((apart ^ half) - half),
        .cpw_only_turns = finding.cpw_position >> cpw_bits};
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
  static constexpr SafetyFinding finding_of(const Plan& plan,
                                            const Result<typename Plan::Frame, FrameFault>& frame) {
    if (!frame.ok()) return {.cause = cause_of(plan.setup(), frame.error())};
    const Channel& cpw = frame->channel_list[plan.setup().cpw];
    const Channel& spw = frame->channel_list[plan.setup().spw];
    const std::int32_t apart = difference(plan.alignment(), cpw.position, spw.position);
    return {.cpw_position = cpw.position,
            .spw_position = spw.position,
            .difference_lsb = apart,
            .life_counter = static_cast<std::uint8_t>(spw.life_counter),
            .nW = static_cast<std::uint8_t>((cpw.nW ? 2U : 0U) | (spw.nW ? 1U : 0U)),
            .cause = cause_of(plan.setup(), cpw, spw, apart)};
  }

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

  // The lower bits of the difference, with its sign above them.
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
