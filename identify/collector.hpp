// Frames of a capture of any length in bounded memory.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "biss/control/control_frame.hpp"
#include "decode/cycle.hpp"
#include "identify/sample.hpp"

namespace biss::identify {

/// START, CDS and STOP of a short frame of control communication, and two more clocks: the shortest
/// frame with data is longer.
inline constexpr std::size_t short_frame_bits = 5;

/// Keeps the first frames of a capture, and of the rest blocks of neighbouring frames, evenly from
/// all of it.
class SampleCollector {
 public:
  /// Takes each cycle, read without a format; keeps those in which START and data were found.
  void add(std::uint64_t number, const decode::Cycle& cycle) {
    const bool asked = zeros_of_cdm_ < control_reset_zeros;
    zeros_of_cdm_ = cycle.cdm == false ? zeros_of_cdm_ + 1 : 0;
    if (cycle.status != CycleStatus::unchecked && cycle.status != CycleStatus::ack_range) {
      return;
    }
    const BitView raw = cycle.raw.view();
    if (raw.size_bits() <= short_frame_bits || !is_wanted(number)) return;
    Sample sample{.cycle = number, .time = cycle.time, .cds = raw[1], .asked = asked, .bits = {}};
    sample.bits.append(raw.from(2));
    samples_.push_back(sample);
    if (samples_.size() == most_) thin_out();
  }

  std::span<const Sample> samples() const { return samples_; }

 private:
  // The meaning of the bits follows from how they move between neighbouring frames.
  static constexpr std::uint64_t block = 64;
  static constexpr std::uint64_t first_cycles_ = 1024;
  static constexpr std::size_t most_ = 3072;

  bool is_wanted(std::uint64_t number) const {
    return number < first_cycles_ || number / block % stride_ == 0;
  }

  void thin_out() {
    while (samples_.size() > most_ / 4 * 3 && stride_ < std::uint64_t{1} << 62U) {
      stride_ *= 2;
      std::erase_if(samples_, [this](const Sample& each) { return !is_wanted(each.cycle); });
    }
  }

  std::vector<Sample> samples_;
  // In a row; the beginning of a capture may be in a control frame.
  std::uint64_t zeros_of_cdm_ = 0;
  std::uint64_t stride_ = 1;
};

}  // namespace biss::identify
