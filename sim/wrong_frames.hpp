// Wrong frames with good checksums that an encoder, or a store on the way, sends instead of its own.
#pragma once

#include <array>
#include <cstdint>

#include "biss/frame/frame.hpp"
#include "sim/fault.hpp"
#include "sim/random.hpp"

namespace biss::sim {

class WrongFrames {
 public:
  void begin(FaultKind kind, std::uint64_t detail) {
    active_ |= set_of(kind);
    if (kind == FaultKind::reorder) age_ = static_cast<std::uint32_t>(2 + detail % 7U);
    if (kind == FaultKind::loss) lost_ = static_cast<std::uint32_t>(1 + detail % 8U);
    if (kind == FaultKind::insert || kind == FaultKind::other_encoder) {
      source_ = detail;
      // Far from the next frames and from the previous ones.
      apart_ = 10 + (detail >> 32U) % 43U;
    }
  }
  void end(FaultKind kind) { active_ &= ~set_of(kind); }

  /// The number of frames lost before the next one; 0 when called again.
  std::uint32_t take_lost() {
    const std::uint32_t lost = lost_;
    lost_ = 0;
    return lost;
  }
  /// Whether the encoder's own sign of life does not count.
  bool holds_counter() const { return is(FaultKind::lc_frozen) || is(FaultKind::insert); }
  /// How many frames another source is ahead; 0 without one.
  std::uint64_t ahead() const { return is_foreign() ? apart_ : 0; }
  /// The distance of another source's position, in units of 2^-64 of the range.
  std::uint64_t position_share() const { return is_foreign() ? scrambled(source_) | 1U : 0; }

  /// Stores a frame, and returns the frame that is sent instead of it.
  const Frame& put(const Frame& own) {
    const std::uint32_t age = is(FaultKind::repeat) ? 1 : is(FaultKind::reorder) ? age_ : 0;
    const std::uint32_t back = age < count_ ? age : count_;
    past_[next_] = own;
    const Frame& sent = past_[(next_ + depth - back) % depth];
    next_ = (next_ + 1U) % depth;
    if (count_ + 1U < depth) ++count_;
    return sent;
  }

 private:
  static constexpr std::uint32_t depth = 9;

  bool is(FaultKind kind) const { return (active_ & set_of(kind)) != 0; }
  bool is_foreign() const { return is(FaultKind::insert) || is(FaultKind::other_encoder); }

  FaultSet active_ = 0;
  std::uint32_t age_ = 0;
  std::uint32_t lost_ = 0;
  std::uint64_t source_ = 0;
  std::uint64_t apart_ = 0;
  std::array<Frame, depth> past_{};
  std::uint32_t next_ = 0;
  std::uint32_t count_ = 0;  // stored frames before this one
};

}  // namespace biss::sim
