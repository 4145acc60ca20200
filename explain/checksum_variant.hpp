// The mistakes that makers of encoders make with the checksum.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "biss/frame/format.hpp"
#include "decode/cycle.hpp"

namespace biss::explain {

enum class Mistake : std::uint8_t {
  reversed,     ///< its bits are in reverse order
  no_flags,     ///< without nE and nW
  cds,          ///< CDS is included
  previous,     ///< the checksum of the frame before
  lsb,          ///< of the position with the lowest bit first, then nE and nW
  all_lsb,      ///< of all data with the lowest bit first
  other_start,  ///< not inverted, or another start value
  constant,     ///< the same in all frames
};

/// A rule by which a checksum is right.
struct ChecksumVariant {
  Mistake mistake{};
  /// The only one; its checksum has the error, if formats have a word for it.
  ChannelFormat channel{};
  /// The constant rest of the checksum, for `other_start` and `constant`.
  std::uint64_t rest = 0;
  /// A format that reads the positions; empty if no format does.
  std::string format{};

  /// \param raw START, CDS, data, checksum … \param before the frame before it
  bool fits(BitView raw, BitView before) const;
  /// The difference of the checksum from the rule without `rest`. \pre both frames are complete
  std::uint64_t rest_of(BitView raw, BitView before) const;
};

/// The mistake in words, for the evidence.
std::string_view text_of(Mistake mistake);

/// A frame without the right checksum, and the one before it: from START on.
struct WrongFrame {
  decode::RawBits raw;
  decode::RawBits before;
};

/// The rule that fits nearly all of these frames.
/// \param format of one channel; without it, the usual checksums of the data before STOP are tried
std::optional<ChecksumVariant> find_variant(std::span<const WrongFrame> frames,
                                            const std::optional<FrameFormat>& format,
                                            unsigned payload_bits);

}  // namespace biss::explain
