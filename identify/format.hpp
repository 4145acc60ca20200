// The frame format that explains the frames of a capture.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "biss/frame/format.hpp"
#include "identify/checksum.hpp"
#include "identify/fields.hpp"
#include "identify/sample.hpp"

namespace biss::identify {

/// A format that fits the frames.
struct FormatCandidate {
  FrameFormat format;
  /// 0 to 1: the probability of the format; see docs/identify.md. At 0.9 and above `decode` uses it.
  double confidence = 0;
  /// Encoders of the catalogue that these frames can be from. Names live as long as the program.
  std::vector<std::string_view> encoders;
  /// Other formats of the catalogue that these frames cannot separate from this one.
  std::vector<FrameFormat> equal;
  /// One for each channel.
  std::vector<Fields> fields;
  Layout layout;
};

/// The format of the frames, as far as they show it.
struct FormatFinding {
  /// The most likely first; empty if there is no frame, or no bit before a possible end.
  std::vector<FormatCandidate> candidates;
  /// No bit of a position has moved: the format cannot be known.
  bool still = false;

  /// The first candidate if it is certain enough to be used without a question.
  const FormatCandidate* sure() const;
};

/// From this confidence on a format is used.
inline constexpr double sure_confidence = 0.9;

/// Both formats accept the same frames, by their checksums and STOP, and the checksums are right in
/// one.
bool same_verdicts(FrameFormat a, FrameFormat b, std::span<const Sample> samples);

/// \param samples frames of one encoder in the order of their cycles
FormatFinding find_format(std::span<const Sample> samples);

/// Frames of one length, one after the other.
struct FormatPart {
  std::uint64_t from_cycle = 0;
  std::uint64_t to_cycle = 0;
  /// The length of most frames, after CDS.
  unsigned bits = 0;
  FormatFinding finding;
};

/// The parts of a capture whose frames change their length or their format: one part if they do
/// not, or if frames of several lengths alternate. Empty if there is no frame.
std::vector<FormatPart> find_parts(std::span<const Sample> samples);

}  // namespace biss::identify
