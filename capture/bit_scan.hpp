// Finds the changes of bits in samples: the innermost loops of the quick way through sampled
// captures, with the processor's vectors and without.
#pragma once

#include <cstddef>
#include <cstdint>

namespace biss::capture {

/// A scan may write up to this number of further times after those it finds.
inline constexpr std::size_t scan_slack = 64;

/// Samples in which the changes of two lines are sought. The times go to `ma` and `slo`, which have
/// room for `count` and `scan_slack` more. A scan updates the levels and both pointers, so that it
/// continues with the samples that follow; `samples`, `count` and `time` must be set again.
struct PairScan {
  const std::uint8_t* samples = nullptr;
  std::size_t count = 0;
  std::size_t unit_bytes = 1;  ///< of a sample, 1 to 8
  unsigned ma_bit = 0;
  unsigned slo_bit = 0;
  bool ma_high = false;   ///< before the first sample
  bool slo_high = false;  ///< before the first sample
  std::int64_t time = 0;  ///< of the first sample
  std::uint32_t step = 1;
  std::int64_t* ma = nullptr;
  std::int64_t* slo = nullptr;
};

/// Finds the changes with the best vectors that this processor has.
void scan_pair(PairScan& scan);

/// The same without vectors.
void scan_pair_plain(PairScan& scan);

}  // namespace biss::capture
