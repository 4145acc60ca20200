// From the evidence in a capture to the likely causes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"
#include "device/words.hpp"
#include "explain/evidence.hpp"
#include "explain/reading.hpp"

namespace biss::explain {

/// A frame format that fits the capture, found without `-f`.
struct IdentifiedFormat {
  FrameFormat format;
  /// 0 to 1.
  double confidence = 0;
};

/// Another protocol that the lines look like.
struct OtherProtocol {
  std::string name;
  /// 0 to 1.
  double confidence = 0;
  /// The figures that support it.
  std::string why;
};

/// Information besides the cycles.
struct Context {
  /// The format by which frames are judged; empty if none is known.
  std::optional<FrameFormat> format;
  /// The user has given it.
  bool given = true;
  /// Frames are judged by the first of the candidates, which is not certain.
  bool assumed = false;
  DeviceTiming timing;
  /// The master of this link compensates the line delay; empty: not known.
  std::optional<bool> compensated;
  /// How the capture was read. The evidence is from these lines.
  Reading reading;
  std::optional<IdentifiedFormat> identified;
  /// Possible formats of the frames if none is certain, the most likely first.
  std::vector<FrameFormat> candidates;
  /// If the frames change their length: each format, and its cycles.
  std::string format_parts;
  std::optional<OtherProtocol> other;
};

/// A likely cause.
struct Finding {
  Cause cause{};
  /// 0 to 1, never 1. The likelihoods of all findings add up to about 1, or less: without a format
  /// `healthy` has 0.5 at most.
  double likelihood = 0;
  /// By how many bits the account of the capture with this cause is longer than the shortest one.
  double bits = 0;
};

/// The kinds of requests that a cause predicts.
std::vector<RequestKind> kinds_of(Cause cause);

/// The likely causes, the likeliest first; unlikely ones are left out. None if the capture has no
/// whole request.
std::vector<Finding> diagnose(const Evidence& evidence, const Context& context);

}  // namespace biss::explain
