// The safety monitor with a format and a setup that are known at run time.
#pragma once

#include <cstddef>
#include <cstring>
#include <optional>

#include "biss/safety/monitor.hpp"

namespace biss::lab {

/// A plan that several monitors share, so that none has tables of its own.
class SharedSafetyPlan {
 public:
  using Codec = SafetyPlan<>::Codec;
  using Frame = SafetyPlan<>::Frame;
  static constexpr std::size_t most_channels = SafetyPlan<>::most_channels;
  static constexpr unsigned most_payload_bits = SafetyPlan<>::most_payload_bits;
  static constexpr unsigned least_payload_bits = SafetyPlan<>::least_payload_bits;
  static constexpr std::size_t most_faults = SafetyPlan<>::most_faults;
  // Faults of this computer's memory are outside the scope of the experiments.
  static constexpr bool checks_memory = false;

  /// \pre the plan outlives this
  explicit SharedSafetyPlan(const SafetyPlan<>& plan)
      : plan_(&plan), fingerprint_(plan.fingerprint()) {}

  const Codec& codec() const { return plan_->codec(); }
  const FrameFormat& format() const { return plan_->format(); }
  unsigned payload_bits() const { return plan_->payload_bits(); }
  const SafetySetup& setup() const { return plan_->setup(); }
  const safety_detail::Alignment& alignment() const { return plan_->alignment(); }
  std::optional<SafetySetupError> mistake() const { return plan_->mistake(); }
  const SafetyFingerprint& fingerprint() const { return fingerprint_; }
  bool is(const SafetyFingerprint& expected) const { return fingerprint_ == expected; }

 private:
  const SafetyPlan<>* plan_;
  SafetyFingerprint fingerprint_;
};

/// A SafetyMonitor that can be copied: only an experiment may return to an earlier state.
class Monitor : public SafetyMonitor<SharedSafetyPlan> {
 public:
  /// \pre the plan outlives this
  explicit Monitor(const SafetyPlan<>& plan) : SafetyMonitor(SharedSafetyPlan(plan)) {}
  Monitor(const Monitor& other) : SafetyMonitor(other.plan()) { *this = other; }
  Monitor& operator=(const Monitor& other) {
    std::memmove(static_cast<void*>(this), &other, sizeof *this);
    return *this;
  }

  bool self_test() { return SafetyMonitor::self_test(plan().fingerprint()); }
  /// Whatever fault is latched.
  void acknowledge() { SafetyMonitor::acknowledge(latched_cause()); }
};

}  // namespace biss::lab
