// A format and a setup made ready for monitoring: known while running, or while compiling.
#pragma once

#include <cstddef>

#include "biss/frame/codec.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/safety/setup.hpp"

namespace biss {

/// Known at run time; with room for `Channels` channels.
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

/// Known at compile time: it takes no memory but flash, and a mistake in the setup stops the build.
///
///   constexpr auto& type = *find_safety_configuration("fs-36-28");
///   SafetyMonitor<FixedSafetyPlan<type.frame_format(), type.setup>> monitor;
template <FrameFormat Format, SafetySetup Setup, class Crc = CrcFast>
class FixedSafetyPlan {
  static_assert(!check_safety(Format, Setup), "see SafetySetupError");

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
