// `decode --fail-on`: which rows make the command fail.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "decode/statistics.hpp"
#include "verbs/decode/safety.hpp"

namespace biss::verbs {

/// The causes of a failure: any, nE, nW, marginal, safety, a SafetyVerdict, limits, a Limit, or a
/// CycleStatus other than ok.
using FailOn = std::vector<std::string>;

/// One line why a word is not a cause; empty if all are causes. The other functions need that.
std::string wrong_cause(const FailOn& causes);

/// Whether a safety monitor is needed.
bool asks_safety(const FailOn& causes);

/// Whether the format of the frame is needed: for nE, nW and crc.
bool asks_format(const FailOn& causes);

/// Whether a line is needed: for marginal and limits.
bool asks_line(const FailOn& causes);

/// The first limit that is requested by name and unknown for this device.
std::optional<decode::Limit> unknown_limit(const FailOn& causes, const DeviceTiming& timing);

/// Whether a row has one of the causes. \param safety null without a monitor
bool is_met(const FailOn& causes, const decode::Statistics& statistics,
            const decode::SafetyWatch* safety);

}  // namespace biss::verbs
