// A format and a setup prepared for monitoring, at run time or at compile time.
#pragma once

#include <cstddef>

#include "biss/frame/codec.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/safety/setup.hpp"

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

  /// \pre !check_safety(format, setup), and format has at most Channels channels
  constexpr SafetyPlan(const FrameFormat& format, const SafetySetup& setup)
      : codec_(format),
        setup_(setup),
        alignment_(safety_detail::alignment_of(format.channel_list[setup.cpw],
                                               format.channel_list[setup.spw], setup.comparison)) {}

  constexpr const Codec& codec() const { return codec_; }
  constexpr const FrameFormat& format() const { return codec_.format(); }
  constexpr unsigned payload_bits() const { return codec_.payload_bits(); }
  constexpr const SafetySetup& setup() const { return setup_; }
  constexpr const safety_detail::Alignment& alignment() const { return alignment_; }

 private:
  Codec codec_;
  SafetySetup setup_;
  safety_detail::Alignment alignment_;
};

/// Prepared at compile time: it takes no memory but flash, and a mistake in the setup stops the
/// build with the sentence below that names it.
///
///   constexpr auto type = safety_configuration("fs-36-28");
///   SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
template <FrameFormat Format, SafetySetup Setup, class Crc = CrcFast>
class FixedSafetyPlan {
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
  static_assert(is_not<SafetySetupError::tolerance>, "tolerance_lsb takes in every position");
  static_assert(is_not<SafetySetupError::start_frames>, "start_frames is less than 2");
  static_assert(is_not<SafetySetupError::counter>,
                "near_frames is above 30, or learn_rollovers is 0");
  static_assert(is_not<SafetySetupError::budget>,
                "too many faults in the budget, or its window is shorter than frame_gap_max");
  static_assert(is_not<SafetySetupError::frame_gap>,
                "not 0 <= frame_gap_min < frame_gap_max <= max_frame_gap, or frame_gap_max is not "
                "shorter than the counter's period");

 public:
  using Codec = FixedCodec<Format, Crc>;
  using Frame = typename Codec::Frame;

  static constexpr std::size_t most_channels = Format.channel_count;
  static constexpr unsigned most_payload_bits = Format.payload_bits();
  static constexpr unsigned least_payload_bits = most_payload_bits;

  static constexpr Codec codec() { return {}; }
  static constexpr const FrameFormat& format() { return Codec::format(); }
  static constexpr unsigned payload_bits() { return most_payload_bits; }
  static constexpr const SafetySetup& setup() { return setup_; }
  static constexpr const safety_detail::Alignment& alignment() { return alignment_; }

 private:
  static constexpr SafetySetup setup_ = Setup;
  static constexpr safety_detail::Alignment alignment_ = safety_detail::alignment_of(
      Format.channel_list[Setup.cpw], Format.channel_list[Setup.spw], Setup.comparison);
};

}  // namespace biss
