// Where the channels of a frame end, and the checksum of each.
//
// The difference of two frames with right checksums is a multiple of the generator, whatever the
// start value and the inversion are. The greatest common divisor of a few differences is therefore
// the generator, times what has not moved. Frames that are damaged are left out by a vote: a
// generator that comes from a few frames must fit most of all frames.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "biss/crc/engines.hpp"
#include "biss/crc/spec.hpp"
#include "identify/sample.hpp"

namespace biss::identify {

/// A channel: its data, and the checksum after it.
struct ChannelLayout {
  unsigned begin = 0;
  unsigned data_bits = 0;
  /// Without a width: the channel has no checksum, or none was found.
  CrcSpec crc;
  /// How many differences of the data are independent: each confirms the checksum once.
  unsigned rank = 0;

  unsigned end() const { return begin + data_bits + crc.width_bits; }
  Span data() const { return {begin, begin + data_bits}; }
  Span all() const { return {begin, end()}; }
};

/// The channels of a frame, and how much speaks for them.
struct Layout {
  std::vector<ChannelLayout> channels;
  /// The evidence less what a choice among N possible layouts costs, in bits: the layout is
  /// 2^score times as likely as a frame without a checksum.
  double score = 0;
  /// The evidence less the number of possible checksums, each as likely as the other.
  double evidence = 0;
  /// The share of the frames in which every checksum is right.
  double right_share = 0;

  unsigned end() const { return channels.empty() ? 0 : channels.back().end(); }
};

/// The layouts that fit the frames, the most likely one first, at most `most`. Empty where there is
/// no frame. The last one is that without any checksum.
std::vector<Layout> find_layouts(std::span<const Sample> samples, std::size_t most);

/// Checks one channel of many frames.
class ChannelCheck {
 public:
  explicit ChannelCheck(const ChannelLayout& channel);

  /// The checksum is right; false where the frame is too short.
  bool is_right(const Sample& sample) const;

 private:
  ChannelLayout channel_;
  CrcTable<8> crc_;
};

/// The frames in which the checksums of all channels are right.
std::vector<const Sample*> right_samples(const Layout& layout, std::span<const Sample> samples);

}  // namespace biss::identify
