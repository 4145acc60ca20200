// An encoder, its master and the line between them, judged from a capture, rule by rule.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/rules.hpp"

namespace biss::decode {

/// The encoder and the master that a capture is compared with.
struct CheckSetup {
  /// Without a format frames are judged by their structure, and by the profile identifier once the
  /// only slave has sent it.
  std::optional<FrameFormat> format;
  /// The default timeout counts as unknown: both timeout rules are then accepted.
  DeviceTiming timing;
  /// CDS is always 0. True for a format with `cds0`, too.
  bool unidirectional = false;
  /// Renishaw's table of cables holds.
  bool renishaw_cables = false;
  /// Whether the data sheet has words of these lengths; empty: no data sheet states them.
  std::optional<bool> has_word_lengths{};
  /// Judges each frame by the safety monitor too. \pre the format allows it: see check_safety()
  std::optional<SafetySetup> safety{};
  /// As in MarginSetup.
  bool compensated = true;
  Picoseconds resolution{};
  /// In counts of the first channel's position per second; 0: not known.
  std::uint64_t speed_max = 0;
};

/// Takes every cycle, measured with MarginSetup::signal. Bounded memory.
class Check {
 public:
  explicit Check(const CheckSetup& setup);
  ~Check();

  void push(std::uint64_t number, const Cycle& cycle);
  void finish();

  RuleResult result(Rule rule) const;
  /// As in the result.
  std::uint64_t faults(Rule rule) const;

 private:
  struct Rules;
  std::unique_ptr<Rules> rules_;
};

}  // namespace biss::decode
