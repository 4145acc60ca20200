// The rows of `biss simulate --truth`: the values that the encoder sent, and the faults of each
// cycle.
#pragma once

#include <cstdint>
#include <string_view>

#include "biss/frame/format.hpp"
#include "sim/line.hpp"
#include "verbs/common/fields.hpp"

namespace biss::verbs {

/// The columns are `cycle,time_ns,position,nE,nW,faults`, then position, nE and nW of each further
/// channel, then `places` (the places of faults in the cycle), `marginal` (our master sampled SLO
/// within 5 % of a period of a change) and `sampled_ns` (when the position of channel 1 was taken).
/// A value is empty if the channel does not have it, or if the channel's position was not sampled.
/// `marginal` is empty with a recorded master.
FieldRow truth_row(const FrameFormat& format, std::uint64_t number,
                   const sim::SimulatedCycle& cycle, std::string_view faults);

}  // namespace biss::verbs
