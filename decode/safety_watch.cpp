#include "decode/safety_watch.hpp"

#include <algorithm>
#include <cstdlib>

#include "biss/safety/monitor.hpp"

namespace biss::decode {

namespace {

using MonitorBits = BitBuffer<RawBits::capacity_bits + 2>;

// START to STOP after the one and the zero that a monitor expects first. Empty if the capture does
// not show these bits.
MonitorBits bits_of(const Cycle& cycle) {
  MonitorBits bits;
  switch (cycle.status) {
    case CycleStatus::ok:
    case CycleStatus::cds:
    case CycleStatus::crc:
    case CycleStatus::stop_bit:
    case CycleStatus::truncated:
      bits.append(0b10, 2);
      bits.append(cycle.raw.view());
      break;
    default:
      break;
  }
  return bits;
}

}  // namespace

class SafetyWatch::Monitor : public SafetyMonitor<SafetyPlan<max_channels>> {
 public:
  using SafetyMonitor::SafetyMonitor;
};

namespace {

// The decoder judges line delay and ACK in time, at any clock: their causes are statuses.
UnratedSafetySetup without_bounds(SafetySetup setup) {
  setup.bounds = {};
  return UnratedSafetySetup(setup);
}

}  // namespace

SafetyWatch::SafetyWatch(const FrameFormat& format, const SafetySetup& setup)
    : monitor_(std::make_unique<Monitor>(SafetyPlan<max_channels>(format, without_bounds(setup)))) {
  // If it fails, every verdict is `self_test`.
  static_cast<void>(monitor_->self_test(monitor_->plan().fingerprint()));
}

SafetyWatch::~SafetyWatch() = default;
SafetyWatch::SafetyWatch(SafetyWatch&& other) noexcept = default;
SafetyWatch& SafetyWatch::operator=(SafetyWatch&& other) noexcept = default;

std::optional<SafetyVerdict> SafetyWatch::judge(const Cycle& cycle, bool counts) {
  if (is_cut(cycle.status) || cycle.status == CycleStatus::ma_glitch) {
    return std::nullopt;
  }
  const MonitorBits bits = bits_of(cycle);
  const SafetyJudgement judgement = monitor_->step(OneClock{cycle.time}, bits.view());
  if (counts) ++counts_[index_of(judgement.verdict)];
  if (cycle.status == CycleStatus::ok) learn(judgement, counts);
  return judgement.verdict;
}

// Learns from the bits on the line, for any range in the setup.
void SafetyWatch::learn(const SafetyJudgement& judgement, bool counts) {
  if (judgement.verdict == SafetyVerdict::latched || judgement.verdict == SafetyVerdict::failed) {
    return;
  }
  if (counts) {
    ++compared_;
    worst_ = std::max(worst_, std::abs(std::int64_t{judgement.difference_lsb}));
    if (last_counter_ == 63 && judgement.life_counter <= 1) ++rollovers_[judgement.life_counter];
  }
  last_counter_ = judgement.life_counter;
}

std::uint64_t SafetyWatch::faults() const {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < safety_verdict_count; ++i) {
    if (is_fault(verdict_of(i))) sum += counts_[i];
  }
  return sum;
}

const SafetySetup& SafetyWatch::setup() const { return monitor_->plan().setup(); }
unsigned SafetyWatch::compared_bits() const { return monitor_->plan().alignment().bits; }

}  // namespace biss::decode
