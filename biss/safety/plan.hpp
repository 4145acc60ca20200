// A format and a setup prepared for monitoring, at run time or at compile time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "biss/frame/codec.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"

namespace biss {

/// Prepared at run time, with room for `Channels` channels.
template <std::size_t Channels = 2, class Crc = CrcFast>
class SafetyPlan {
 public:
  using Codec = FrameCodec<Crc, Channels>;
  using Frame = typename Codec::Frame;

  static constexpr std::size_t most_channels = Channels;
  static constexpr unsigned most_payload_bits = Channels * max_channel_bits;
  static constexpr unsigned least_payload_bits = 0;
  /// The most faults that a budget of this plan can tolerate; at least 1.
  static constexpr std::size_t most_faults = max_tolerated_faults;
  /// Whether a monitor checks its memory before each use.
  static constexpr bool checks_memory = true;

  /// The self test of a monitor fails if check_safety(format, setup) finds a mistake, or if the
  /// format has more than `Channels` channels (the mistake `channels`).
  constexpr SafetyPlan(const FrameFormat& format, const SafetySetup& setup)
      : SafetyPlan(format, setup, true) {}
  /// For a monitor without a rating: the self test fails if check_safety(format,
  /// UnratedSafetySetup(setup)) finds a mistake.
  constexpr SafetyPlan(const FrameFormat& format, const UnratedSafetySetup& setup)
      : SafetyPlan(format, setup, false) {}

  constexpr const Codec& codec() const { return codec_; }
  constexpr const FrameFormat& format() const { return codec_.format(); }
  constexpr unsigned payload_bits() const { return codec_.payload_bits(); }
  constexpr const SafetySetup& setup() const { return setup_; }
  constexpr const safety_detail::Alignment& alignment() const { return alignment_; }
  /// The mistake that keeps a monitor from working.
  constexpr std::optional<SafetySetupError> mistake() const {
    return rated_ != 0 ? check_safety(format(), setup_)
                       : check_safety(format(), UnratedSafetySetup(setup_));
  }
  /// The fingerprint of the plan as it is in memory now.
  constexpr SafetyFingerprint fingerprint() const { return {format(), setup_, rated_}; }
  /// Whether the plan still has this fingerprint. The monitor checks it before every frame. The
  /// fingerprint does not cover the tables of the first evaluation; a fault in them makes the two
  /// evaluations differ.
  constexpr bool is(const SafetyFingerprint& expected) const {
    if (fingerprint() != expected || payload_bits() != format().payload_bits()) return false;
    if (!has_words()) return false;
    if (alignment_ != safety_detail::alignment_of(format().channel_list[setup_.cpw],
                                                  format().channel_list[setup_.spw],
                                                  setup_.comparison)) {
      return false;
    }
    for (std::size_t k = 0; k < format().channel_count; ++k) {
      const CrcSpec& expected_crc = format().channel_list[k].crc;
      if (SafetyFingerprint::word_of(codec_.engine_spec(k)) !=
          SafetyFingerprint::word_of(expected_crc)) {
        return false;
      }
    }
    return true;
  }

 private:
  constexpr SafetyPlan(const FrameFormat& format, const SafetySetup& setup, bool rated)
      : codec_(format.channel_count <= Channels ? format : FrameFormat{}),
        setup_(setup),
        rated_(rated ? 1 : 0) {
    if (!has_words()) return;
    const auto& channels = codec_.format().channel_list;
    alignment_ =
        safety_detail::alignment_of(channels[setup.cpw], channels[setup.spw], setup.comparison);
  }

  constexpr bool has_words() const {
    return setup_.cpw < format().channel_count && setup_.spw < format().channel_count;
  }

  Codec codec_;
  SafetySetup setup_;
  safety_detail::Alignment alignment_{};
  std::uint8_t rated_;
};

/// Prepared at compile time, for a SafetySetup or an UnratedSafetySetup. It takes flash and no RAM. A
/// mistake in the setup stops the build with the sentence below that names it.
///
///   constexpr auto type = safety_configuration("fs-36-28");
///   SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
template <FrameFormat Format, auto Setup, class Crc = CrcFast>
class FixedSafetyPlan {
  static_assert(std::is_base_of_v<SafetySetup, decltype(Setup)>,
                "the setup is a SafetySetup or an UnratedSafetySetup");
  template <SafetySetupError Mistake>
  static constexpr bool is_not = check_safety(Format, Setup) != Mistake;

  static_assert(is_not<SafetySetupError::channels>,
                "a word is not in the frame, or CPW and SPW are the same channel");
  static_assert(is_not<SafetySetupError::no_crc>, "a word has no CRC");
  static_assert(is_not<SafetySetupError::no_error_bit>, "a word has no nE");
  static_assert(is_not<SafetySetupError::no_position>, "a word has no position");
  static_assert(is_not<SafetySetupError::gray>,
                "a word's position is in Gray code and cannot be compared");
  static_assert(is_not<SafetySetupError::no_counter>,
                "the SPW has no sign-of-life counter of 6 bits (lc6)");
  static_assert(is_not<SafetySetupError::compare_bits>,
                "compare_bits is more than both words have");
  static_assert(is_not<SafetySetupError::tolerance>, "tolerance_lsb accepts every position");
  static_assert(is_not<SafetySetupError::start_frames>, "start_frames is less than 2");
  static_assert(is_not<SafetySetupError::counter>,
                "near_frames is above 30, learn_rollovers is 0, or the first value is above 63");
  static_assert(is_not<SafetySetupError::budget>,
                "too many faults in the budget, or its window is shorter than frame_gap_max");
  static_assert(
      is_not<SafetySetupError::frame_gap>,
      "not 0 <= frame_gap_min < frame_gap_max <= max_frame_gap, frame_gap_max is not "
      "shorter than the counter's period times frame_gap_min, or cycle_min is not above 0 "
      "and at most max_frame_gap; at_cycle() sets all three");
  static_assert(is_not<SafetySetupError::clocks>,
                "the clocks' tolerance is not from 0 to below frame_gap_max, or bit_period is not "
                "from 0 to 1 ms");
  static_assert(is_not<SafetySetupError::bounds>,
                "no frame is within the bounds: a minimum is above its maximum, or above the "
                "possible range, or with_timing() has a clock above the encoder's limit");
  static_assert(is_not<SafetySetupError::checksum>,
                "the CPW's CRC is not 0x43, or the SPW's is not 0x190D9; UnratedSafetySetup "
                "permits it");
  static_assert(is_not<SafetySetupError::weak_comparison>,
                "fewer than 9 bits are compared, or tolerance_lsb is above 1; UnratedSafetySetup "
                "permits it");
  static_assert(is_not<SafetySetupError::unrated>,
                "the words have no rating ('biss safety analyse --to c' prints it); "
                "UnratedSafetySetup permits it");
  static_assert(is_not<SafetySetupError::residual>,
                "more undetected errors an hour than residual_max_e15; UnratedSafetySetup permits "
                "it");

 public:
  using Codec = FixedCodec<Format, Crc>;
  using Frame = typename Codec::Frame;

  static constexpr std::size_t most_channels = Format.channel_count;
  static constexpr unsigned most_payload_bits = Format.payload_bits();
  static constexpr unsigned least_payload_bits = most_payload_bits;
  static constexpr std::size_t most_faults = std::max<std::size_t>(Setup.budget.faults, 1);
  static constexpr bool checks_memory = true;

  static constexpr Codec codec() { return {}; }
  static constexpr const FrameFormat& format() { return Codec::format(); }
  static constexpr unsigned payload_bits() { return most_payload_bits; }
  static constexpr const SafetySetup& setup() { return setup_; }
  static constexpr const safety_detail::Alignment& alignment() { return alignment_; }
  static constexpr std::optional<SafetySetupError> mistake() { return std::nullopt; }
  static constexpr SafetyFingerprint fingerprint() { return fingerprint_; }
  static constexpr bool is(const SafetyFingerprint& expected) { return fingerprint_ == expected; }

 private:
  static constexpr SafetyFingerprint fingerprint_{Format, Setup};
  static constexpr SafetySetup setup_ = Setup;
  static constexpr safety_detail::Alignment alignment_ = safety_detail::alignment_of(
      Format.channel_list[Setup.cpw], Format.channel_list[Setup.spw], Setup.comparison);
};

namespace safety_detail {

// Converts a position from counts of the SPW to counts of the CPW: the inverse of spw_position().
template <class Plan>
constexpr std::uint64_t in_cpw_counts(const Plan& plan, std::uint64_t position) {
  const auto& channels = plan.format().channel_list;
  return spw_position(channels[plan.setup().spw], channels[plan.setup().cpw], position);
}

}  // namespace safety_detail

/// The CPW's position of a safe frame, for motion control only: only the CPW's CRC protects its fine
/// bits and the turns that are not compared.
template <class Plan>
constexpr std::uint64_t control_position(const Plan& plan, const SafePosition& position) {
  const unsigned bits = plan.alignment().bits + plan.alignment().cpw_shift;
  const std::uint64_t aligned = safety_detail::in_cpw_counts(plan, position.value);
  const std::uint64_t offset = static_cast<std::uint64_t>(position.cpw_only_offset);
  return position.cpw_only_turns << bits | ((aligned + offset) & low_mask(bits));
}

}  // namespace biss
