// A format and a setup, ready for sequences of frames; and an encoder that moves and counts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "biss/base/units.hpp"
#include "biss/frame/encode.hpp"
#include "lab/campaign_frame.hpp"
#include "lab/sequence.hpp"
#include "sim/random.hpp"
#include "sim/sign_of_life.hpp"

namespace biss::lab {

/// The content of one frame from the encoder, with no error.
struct SequenceWords {
  std::uint64_t cpw = 0;
  std::uint64_t spw = 0;
  std::uint8_t life_counter = 0;
  bool cpw_nW = true;
  bool spw_nW = true;

  bool operator==(const SequenceWords&) const = default;
};

/// The plan of one row's monitors, and the codecs of encoders that send to it.
class SequenceFrame {
 public:
  using Plan = CampaignFrame::Plan;
  using Codec = Plan::Codec;

  /// \return nothing if CampaignFrame::make() returns nothing, or if the monitor's self test fails
  static std::optional<SequenceFrame> make(const FrameFormat& format, SafetySetup setup,
                                           CounterMode counter, CounterMode encoder_counter);

  const Plan& plan() const { return *plan_; }
  const SafetySetup& setup() const { return plan_->setup(); }
  /// The same pair of words with the encoder's counter, for theory.
  const CampaignFrame& words() const { return words_; }
  const Codec& codec() const { return plan_->codec(); }
  /// From request to request.
  Picoseconds cycle() const;
  /// From a request that is not answered in time to the watchdog's bound, in cycles, rounded up.
  unsigned watchdog_cycles() const;

  /// Encoders of the same type with other start values of their CRCs: of the SPW, of the CPW, or of
  /// both. Their checksums differ from ours for all data.
  const std::vector<Codec>& other_starts() const { return other_starts_; }
  /// Encoders of the same type with another polynomial of the SPW's CRC.
  const std::vector<Codec>& other_polynomials() const { return other_polynomials_; }

  /// The frame as an encoder with this codec sends it. Beginning and length of ACK are drawn within
  /// the setup's bounds, up to 16 clocks each.
  FrameBits encode(const SequenceWords& words, const Codec& codec, sim::Random& random) const;
  FrameBits encode(const SequenceWords& words, sim::Random& random) const {
    return encode(words, codec(), random);
  }
  /// The place of the payload's first bit in encoded bits.
  std::size_t payload_at(const FrameBits& bits) const {
    return bits.size_bits() - 1U - words_.bits();
  }

 private:
  SequenceFrame(const CampaignFrame& words, std::shared_ptr<const Plan> plan);

  CampaignFrame words_;
  std::shared_ptr<const Plan> plan_;
  std::vector<Codec> other_starts_;
  std::vector<Codec> other_polynomials_;
};

/// How the safety word is derived from the position.
enum class WordRule : std::uint8_t {
  truncated,  ///< the upper part of the control word
  rounded,    ///< by a scale of its own: up to the tolerance off, in both directions
};

/// An encoder that moves and counts, frame by frame; both words come from one true position.
class SequenceEncoder {
 public:
  /// Begins at a random position. \pre counter is not `learned`
  SequenceEncoder(const SequenceFrame& frame, CounterMode counter, SequenceMotion motion,
                  WordRule rule, std::uint64_t seed);

  /// The next frame, after a move and a step of the counter. Warnings are random.
  SequenceWords next();
  /// A frame of another encoder of this type, at any position, with any counter.
  SequenceWords foreign(sim::Random& random) const;
  /// Changes to another position and another counter.
  void put_elsewhere();
  /// Whether warnings are sent from now on.
  void warn(bool sometimes) { warns_ = sometimes; }

  std::uint64_t position_wraps() const { return position_wraps_; }
  std::uint64_t counter_wraps() const { return counter_wraps_; }

 private:
  void begin_stretch();
  void move();
  std::uint64_t position() const { return place_ >> (64U - position_bits_); }
  std::uint64_t spw_of(std::uint64_t position);
  std::uint64_t full_speed();
  std::uint64_t any_speed();

  const ChannelFormat& cpw_;
  const ChannelFormat& spw_;
  SequenceMotion motion_;
  sim::SignOfLife life_;
  sim::Random random_;
  unsigned position_bits_;
  // The largest error in counts of the safety word; 0 if it is truncated.
  std::uint64_t off_;
  // In parts of 2^64 of the range, so that passing zero is an overflow.
  std::uint64_t place_ = 0;
  std::uint64_t speed_ = 0;
  std::uint64_t stretches_ = 0;
  std::uint64_t frames_ = 0;
  unsigned in_stretch_ = 0;
  bool warns_ = true;
  std::uint64_t position_wraps_ = 0;
  std::uint64_t counter_wraps_ = 0;
  std::uint32_t life_counter_ = 0;
};

}  // namespace biss::lab
