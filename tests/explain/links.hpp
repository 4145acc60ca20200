// Captures of links that do not work, each with its true cause, made by the simulator.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"
#include "device/words.hpp"
#include "explain/diagnose.hpp"
#include "wire/edge.hpp"

namespace biss::explain::test {

/// A capture, and the options of its user.
struct Link {
  Cause truth{};
  /// How it was made.
  std::string story;
  std::vector<wire::Edge> edges;
  Picoseconds end{};
  decode::Lines lines{.ma = 0, .slo = 1};
  FrameFormat format;
  DeviceTiming timing;
  /// As the file states it; 0 if it contains changes.
  Picoseconds resolution{};
};

/// A capture with this cause, of random encoder, clock, cable, motion and strength. The same seed
/// gives the same capture. At least 10 cycles are affected.
Link make_link(Cause truth, std::uint64_t seed);

/// The findings of `biss explain`; the truth is not used.
std::vector<Finding> explain_link(const Link& link);

/// The evidence in it, for messages of tests.
Evidence observe_link(const Link& link);

}  // namespace biss::explain::test
