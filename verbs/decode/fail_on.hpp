// `decode --fail-on`: which rows make the command fail.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "decode/statistics.hpp"
#include "verbs/decode/safety.hpp"

namespace biss::verbs {

class FailOn {
 public:
  /// any, nE, nW, marginal, safety, a SafetyVerdict, limits, a Limit, or a CycleStatus other than
  /// ok.
  /// \return an empty text, or one line why a word is wrong
  std::string read(const std::vector<std::string>& words);

  /// Whether a safety monitor is needed.
  bool asks_safety() const { return safety_ || !verdicts_.empty(); }

  /// Whether the format of the frame is needed: for nE, nW and crc.
  bool asks_format() const;

  /// Whether a line is needed: for marginal and limits.
  bool asks_line() const { return marginal_ || limits_ || !each_limit_.empty(); }

  /// The first limit that is requested by name and unknown for this device.
  std::optional<decode::Limit> unknown_limit(const DeviceTiming& timing) const;

  /// \param safety null without a monitor
  bool met_by(const decode::Statistics& statistics, const decode::SafetyWatch* safety) const;

 private:
  bool any_ = false;
  bool error_ = false;
  bool warning_ = false;
  bool marginal_ = false;
  bool safety_ = false;
  bool limits_ = false;
  std::vector<SafetyVerdict> verdicts_;
  std::vector<CycleStatus> statuses_;
  std::vector<decode::Limit> each_limit_;
};

}  // namespace biss::verbs
