// Samples to edges.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "capture/edge_block.hpp"
#include "capture/sample_clock.hpp"
#include "capture/sample_layout.hpp"

namespace biss::capture {

/// Finds the changes in a stream of samples that comes in pieces of any length; a piece may end
/// inside a sample. A change has the time of the first sample that shows it; the first sample gives
/// each line's initial level, at time 0.
class SampleScanner {
 public:
  /// \pre fault_of(layout) is null
  explicit SampleScanner(const RawLayout& layout);

  /// Takes bytes off the front of `piece` until none is left, the block is full or the times are
  /// used up, and returns how many.
  std::size_t scan(std::span<const std::uint8_t> piece, EdgeBlock& block);

  /// Whole samples seen.
  std::uint64_t samples() const { return samples_; }
  /// The bytes so far end inside a sample.
  bool inside_sample() const { return held_bytes_ != 0; }
  /// The next sample would lie beyond what picoseconds can tell.
  bool times_used_up() const { return samples_ > last_index_; }
  /// Time of the last sample; 0 before the first.
  Picoseconds end_time() const {
    return samples_ == 0 ? Picoseconds{} : clock_.time_of(samples_ - 1);
  }

 private:
  template <std::size_t UnitBytes>
  const std::uint8_t* scan_whole(const std::uint8_t* at, const std::uint8_t* end, EdgeBlock& block);
  const std::uint8_t* scan_units(const std::uint8_t* at, const std::uint8_t* end, EdgeBlock& block);
  const std::uint8_t* finish_held(const std::uint8_t* at, const std::uint8_t* end,
                                  EdgeBlock& block);
  void push_changes(std::uint64_t sample, std::uint64_t changed, EdgeBlock& block);

  SampleClock clock_;
  std::uint64_t last_index_;
  std::size_t unit_bytes_;
  std::uint64_t mask_ = 0;
  std::array<wire::LineIndex, 64> line_of_bit_{};
  std::uint64_t samples_ = 0;
  std::uint64_t last_ = 0;
  std::array<std::uint8_t, max_unit_bytes> held_{};
  std::size_t held_bytes_ = 0;
};

}  // namespace biss::capture
