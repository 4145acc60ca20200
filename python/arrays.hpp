// Captures in the caller's memory, or pushed from there.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "capture/edge_source.hpp"
#include "capture/pair_source.hpp"

namespace biss::python {

inline constexpr wire::LineIndex ma_line = 0;
inline constexpr wire::LineIndex slo_line = 1;

/// From `times[i]` on, in picoseconds, MA and SLO have the levels `ma[i]` and `slo[i]`: 0 is low,
/// anything else is high. The three have the same length.
struct EdgeArrays {
  std::span<const std::int64_t> times;
  std::span<const std::uint8_t> ma;
  std::span<const std::uint8_t> slo;
  /// The same as EdgeSource::sample_period().
  Picoseconds sample_period{};
};

/// The arrays as a capture with the lines MA and SLO, read without a copy: they must outlive it.
/// Fails with `empty`; reading fails with `time_backwards`.
capture::Opened open_arrays(const EdgeArrays& arrays);

/// The edges of a capture that come in while it is read.
class EdgeQueue {
 public:
  /// The levels of both lines from this time on. \pre time is not before the last one
  void push(Picoseconds time, bool ma, bool slo);
  void set_period(Picoseconds period) { period_ = period; }
  void set_end(Picoseconds end) { end_ = std::max(end_, end); }
  bool empty() const { return edges_.empty(); }
  std::size_t size() const { return edges_.size(); }
  /// The queued edges go to the reader.
  std::vector<wire::Edge> take() { return std::exchange(edges_, {}); }
  Picoseconds end_time() const { return end_; }
  Picoseconds sample_period() const { return period_; }

  /// The capture, which this must outlive. If no edges are left, next_block() and the pieces of pairs()
  /// are empty; the caller decides whether that is the end.
  std::unique_ptr<capture::EdgeSource> source();

 private:
  void put(Picoseconds time, wire::LineIndex line, bool high, wire::Level& last);

  std::vector<wire::Edge> edges_;
  wire::Level ma_ = wire::Level::unknown;
  wire::Level slo_ = wire::Level::unknown;
  bool begun_ = false;
  Picoseconds end_{};
  Picoseconds period_{};
};

}  // namespace biss::python
