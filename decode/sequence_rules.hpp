// Rules on how requests and frames follow one another, and on nE, nW and the sign of life.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/rules.hpp"

namespace biss::decode {

/// Finds requests that are missing in a regular sequence.
class RequestGaps {
 public:
  /// Takes the next interval. \return how many requests are missing in the previous interval; empty
  ///   if that is unknown, because the requests do not come at one rate
  std::optional<std::uint64_t> push(Picoseconds interval, Picoseconds doubt);
  void reset() { usual_count_ = 0, gap_.reset(); }

 private:
  bool is_usual(Picoseconds interval, Picoseconds doubt) const;

  // Equal intervals in a row that make a rate.
  static constexpr unsigned needed = 4;
  // A longer interval is a pause of the master.
  static constexpr std::int64_t most_times = 10;

  Picoseconds usual_{};
  unsigned usual_count_ = 0;
  // The previous interval as a multiple of the usual one, if it is one.
  std::optional<std::uint64_t> gap_;
};

class SequenceRules {
 public:
  SequenceRules(const std::optional<FrameFormat>& format, const DeviceTiming& timing,
                std::uint64_t speed_max, Tallies& tallies, bool counts_to_63 = false);

  void push(std::uint64_t number, const Cycle& cycle);

 private:
  void judge_interval(std::uint64_t number, const Cycle& cycle);
  void judge_flags(std::uint64_t number, const Frame& frame);
  void judge_life(std::uint64_t number, const Frame& frame);
  void judge_speed(std::uint64_t number, const Cycle& cycle, const Frame& frame);

  std::optional<FrameFormat> format_;
  // The sampling moment of the position varies by this much from frame to frame.
  Picoseconds sampling_spread_;
  std::uint64_t speed_max_;
  Tallies& tallies_;
  // The data sheet names 63 values of the sign of life.
  bool counts_to_63_;
  RequestGaps gaps_;
  std::optional<Picoseconds> last_request_;
  std::uint64_t last_number_ = 0;
  // The frame of the previous cycle, if it was good.
  std::optional<Frame> last_frame_;
  // The position of the last good cycle.
  std::optional<std::uint64_t> last_position_;
  Picoseconds position_time_{};
};

}  // namespace biss::decode
