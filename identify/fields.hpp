// What the data bits of a channel mean: position, flags, sign of life, padding. It follows from how
// the bits move from frame to frame; what has not moved is not known.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "biss/frame/format.hpp"
#include "identify/coding.hpp"

namespace biss::identify {

/// What is doubtful about the meaning of the bits.
enum class Doubt : std::uint8_t {
  still,         ///< no bit of the position has moved
  order,         ///< the position jumps: the order of its bits, or Gray code, cannot be seen
  flag_level,    ///< a flag is mostly 0: an active flag, or one that is active-high
  flag_place,    ///< a bit changes for single frames and is not where flags usually are
  counter,       ///< part of a position that counts frames, or a sign of life
  low_bits,      ///< the lowest bits of the position hardly move, and flags do
  further_bits,  ///< bits move that are neither position, flag nor sign of life
};

inline constexpr std::size_t doubt_count = 7;

/// The meaning of a channel's bits, without the checksum.
struct Fields {
  ChannelFormat channel;
  /// Bits that were seen as 0 and as 1.
  std::uint64_t moved = 0;
  /// Of `moved`, those of the position and of the flags.
  std::uint64_t position_moved = 0;
  std::uint64_t flags_moved = 0;
  std::vector<Doubt> doubts;
};

/// \param words in the order of their cycles
/// \param data_bits of the channel, 1 to 64
/// \param strays words that may be damaged in spite of a right checksum, at most
Fields find_fields(std::span<const DataWord> words, unsigned data_bits, double strays);

}  // namespace biss::identify
