// The ends of the channels of a frame, and the checksum of each.
//
// For a generator g let S(e) be the sum of bit_i x^-i mod g over the first e bits of a frame. The
// bits from b to e leave the same remainder in all frames exactly if S(e) ^ S(b) is the same in
// all. One table of S tests every begin and every end. Two frames with the same remainder differ by
// a multiple of the generator, whatever the start value and the inversion are.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "biss/crc/spec.hpp"
#include "identify/sample.hpp"

namespace biss::identify {

/// A channel: its data, and the checksum after it.
struct ChannelLayout {
  unsigned begin = 0;
  unsigned data_bits = 0;
  /// Without a width: the channel has no checksum, or none was found.
  CrcSpec crc;
  /// The number of last data bits that the checksum does not cover (CrcSpec::without_flags).
  unsigned flags = 0;
  /// How many differences of the data are independent: each confirms the checksum once.
  unsigned rank = 0;

  unsigned end() const { return begin + data_bits + crc.width_bits; }
};

/// Frames of one length, and which of them are equal.
struct FrameSet {
  struct Pattern {
    const Sample* sample = nullptr;
    double frames = 0;
  };

  /// Takes up to `most` frames: those at the beginning, and blocks from all of the rest. Frames of
  /// a different length than most of the long ones are left out, longer ones are cut.
  FrameSet(std::span<const Sample> samples, std::size_t most);

  unsigned length = 0;
  std::vector<const Sample*> samples;
  /// For each sample, the one before if it answers the request before.
  std::vector<const Sample*> before;
  /// For each sample, its pattern.
  std::vector<std::size_t> pattern;
  std::vector<Pattern> patterns;
};

/// The channels of a frame, and their cost.
struct Layout {
  std::vector<ChannelLayout> channels;
  /// The prior bits of the layout, and the bits for everything that its channels do not explain:
  /// frames with another checksum, and bits after the frame.
  double cost = 0;
  /// How much likelier than this layout a layout is whose checksums were not tried.
  double unknown = 0;
  /// The bits by which the checksums are better than chance.
  double score = 0;
  /// The same, less the frames that do not fit, roughly.
  double rating = 0;
  /// The share of the frames in which every checksum is right.
  double right_share = 0;
  /// The same, for each frame of the set.
  std::vector<bool> right;

  unsigned end() const { return channels.empty() ? 0 : channels.back().end(); }
  bool checked() const {
    return std::all_of(channels.begin(), channels.end(),
                       [](const ChannelLayout& each) { return each.crc.present(); });
  }
};

/// The layouts that may fit the frames, at most `most`. Empty if there is no frame. The last one
/// has no checksum.
std::vector<Layout> find_layouts(const FrameSet& frames, std::size_t most);

}  // namespace biss::identify
