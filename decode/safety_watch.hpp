// A BiSS Safety encoder in a capture: a verdict for every cycle, and the totals of the verdicts.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "biss/frame/format.hpp"
#include "biss/safety/setup.hpp"
#include "biss/safety/verdict.hpp"
#include "decode/cycle.hpp"

namespace biss::decode {

/// Runs the safety monitor over the cycles of a capture. The monitor itself is compiled once, in
/// safety_watch.cpp.
class SafetyWatch {
 public:
  /// \pre !check_safety(format, UnratedSafetySetup(setup))
  SafetyWatch(const FrameFormat& format, const SafetySetup& setup);
  ~SafetyWatch();
  SafetyWatch(SafetyWatch&& other) noexcept;
  SafetyWatch& operator=(SafetyWatch&& other) noexcept;

  /// The verdict on the next cycle. Empty if the cycle is not a whole request: it is cut by an end
  /// of the capture, or it is a pulse.
  /// \param counts false: the verdict only prepares the next cycles and is not added to the totals
  std::optional<SafetyVerdict> judge(const Cycle& cycle, bool counts = true);

  std::uint64_t count(SafetyVerdict verdict) const { return counts_[index_of(verdict)]; }
  /// Number of verdicts that are a fault.
  std::uint64_t faults() const;

  const SafetySetup& setup() const;
  /// Number of good frames whose two words were compared.
  std::uint64_t compared() const { return compared_; }
  /// The largest difference of the two words, in counts of the lowest of compared_bits().
  std::int64_t worst_difference() const { return worst_; }
  unsigned compared_bits() const;
  /// How often the sign of life went from 63 to 0, and from 63 to 1: its period is 64 or 63.
  std::uint64_t rollovers_to_0() const { return rollovers_[0]; }
  std::uint64_t rollovers_to_1() const { return rollovers_[1]; }

 private:
  class Monitor;

  void learn(const SafetyJudgement& judgement, bool counts);

  std::unique_ptr<Monitor> monitor_;
  std::array<std::uint64_t, safety_verdict_count> counts_{};
  std::uint64_t compared_ = 0;
  std::int64_t worst_ = 0;
  std::optional<std::uint8_t> last_counter_;
  std::array<std::uint64_t, 2> rollovers_{};
};

}  // namespace biss::decode
