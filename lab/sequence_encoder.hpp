// An encoder that moves and counts, frame by frame; both its words come from one true place.
#pragma once

#include <cstdint>

#include "lab/sequence_frame.hpp"
#include "sim/random.hpp"
#include "sim/sign_of_life.hpp"

namespace biss::lab {

/// How the safety word is made of the place.
enum class WordRule : std::uint8_t {
  truncated,  ///< the control word's upper part
  rounded,    ///< by a scale of its own: off by anything up to the tolerance, either way
};

class SequenceEncoder {
 public:
  /// Stands where `random` says. \pre counter is not `learned`
  SequenceEncoder(const SequenceFrame& frame, CounterMode counter, SequenceMotion motion,
                  WordRule rule, std::uint64_t seed);

  /// The next frame: a move and a count further. Warnings come now and then.
  SequenceWords next();
  /// A frame of another encoder of this type, anywhere, with any counter.
  SequenceWords foreign(sim::Random& random) const;
  /// Goes to another place, and on from another counter.
  void put_elsewhere();
  /// Warnings from now on, or none.
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
  // Up to so many counts of the safety word it is off; 0 where it is truncated.
  std::uint64_t off_;
  // Of the range in parts of 2^64, so that a passage through zero is an overflow.
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
