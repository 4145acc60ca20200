// The meaning of the data bits of a channel: position, flags, sign of life, padding. The meaning
// that takes the fewest bits to write the frames down is the likeliest.
#pragma once

#include <cstdint>
#include <vector>

#include "biss/frame/codec.hpp"
#include "identify/checksum.hpp"
#include "identify/coding.hpp"

namespace biss::identify {

/// The bits of a field in a word.
constexpr std::uint64_t mask_of(const Field& field) { return low_mask(field.bits) << field.shift; }
constexpr std::uint64_t mask_of(const FlagField& flag) {
  return std::uint64_t{flag.present ? 1U : 0U} << flag.shift;
}

/// How the bits of a position are a number.
enum class Coding : std::uint8_t {
  binary,
  gray,
  singleturn_gray,  ///< the bits below `split` are Gray code
  multiturn_gray,   ///< the bits above
  both_gray,        ///< each alone
  lsb_first,
  two_tracks,  ///< the bits above and below `split` are numbers that move alone
};

/// The meaning of a channel's bits.
struct Fields {
  ChannelFormat channel;
  Coding coding = Coding::binary;
  unsigned split = 0;
  /// Bits that were seen as 0 and as 1.
  std::uint64_t moved = 0;
  /// The bits in `moved` that belong to the position.
  std::uint64_t position_moved = 0;
  /// In bits, the choice of the meaning included.
  double cost = 0;
};

/// The frames of one channel whose checksums are right.
struct ChannelWords {
  std::vector<std::uint64_t> data;
  std::vector<std::uint64_t> cycles;
};

/// All meanings, the likeliest first; empty if there is no word.
/// \param layout of the channel
std::vector<Fields> find_fields(const ChannelWords& words, const Timeline& timeline,
                                const ChannelLayout& layout);

}  // namespace biss::identify
