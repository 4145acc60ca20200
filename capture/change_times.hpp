// From scans of samples to the changes of a line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "capture/bit_scan.hpp"
#include "capture/pair_source.hpp"
#include "capture/samples.hpp"

namespace biss::capture {

/// Samples that are scanned at once.
inline constexpr std::size_t scan_samples = 4'096;

/// A piece with more changes of both lines does not become arrays: each of them takes 8 bytes, a
/// sample perhaps one. Its samples are scanned again when it is settled, and become edges.
inline constexpr std::size_t most_changes = std::size_t{1} << 22U;

/// How a scan of `scan_samples` counts: in picoseconds, or where a period is no whole number of
/// them, in samples from its first one on.
class ScanClock {
 public:
  explicit ScanClock(const SampleClock& clock) : clock_(clock), step_(clock.whole_step()) {}

  std::int64_t time_of(std::uint64_t index) const {
    return step_ == 0 ? 0 : clock_.time_of(index).count;
  }
  std::uint32_t step() const { return step_ == 0 ? 1 : step_; }
  /// What a scan from sample `first` on has found becomes times.
  void finish(std::uint64_t first, std::span<std::int64_t> found) const {
    if (step_ == 0) clock_.times_after(first, found);
  }

 private:
  SampleClock clock_;
  std::uint32_t step_;
};

/// Collects what scans find of a line.
class ChangeTimes {
 public:
  /// \param first_high level of the first sample
  ChangeTimes(LineChanges& changes, bool first_high) : times_(&changes.times) {
    changes.first_high = first_high;
  }

  /// Room for a scan of that many samples.
  std::int64_t* room(std::size_t samples) {
    const std::size_t needed = found_ + samples + scan_slack;
    if (times_->size() < needed) times_->resize(needed);
    return times_->data() + found_;
  }
  /// A scan that began at the room, with sample `first`, has put times up to `end`.
  void found(const std::int64_t* end, std::uint64_t first, const ScanClock& clock) {
    const std::size_t before = found_;
    found_ = static_cast<std::size_t>(end - times_->data());
    clock.finish(first, std::span(*times_).subspan(before, found_ - before));
  }
  void finish() { times_->resize(found_); }
  std::size_t count() const { return found_; }

 private:
  std::vector<std::int64_t, Unfilled<std::int64_t>>* times_;
  std::size_t found_ = 0;
};

}  // namespace biss::capture
