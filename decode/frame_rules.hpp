// Rules on a single request and its frame: limits of the master, structure, times.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/limits.hpp"
#include "decode/rules.hpp"

namespace biss::decode {

/// Whether a request with this status proves nothing: the device could not answer it in full, or
/// the capture does not show the answer.
bool is_no_evidence(CycleStatus status);
/// START was found, and MA ran as it should.
bool has_times(CycleStatus status);

class FrameRules {
 public:
  /// \param unidirectional CDS is always 0
  FrameRules(const DeviceTiming& timing, bool unidirectional, Tallies& tallies);

  void push(std::uint64_t number, const Cycle& cycle);
  /// After the last cycle: judges the requests of a capture in which no request has START.
  void finish();
  /// Whether MA must rest after an aborted request for as long as a whole one takes (Renishaw).
  static bool knows_reset(const DeviceTiming& timing) {
    return timing.timeout.rule == TimeoutRule::cycle && timing.cycle_min.count != 0;
  }
  /// The reason why no frame is a case of frame_structure; empty if a frame is a case.
  std::string_view no_frame() const;

 private:
  // Requests without START that may have been too short: the end of the capture decides.
  struct Unanswered {
    std::uint64_t count = 0;
    std::uint64_t first = 0;
    CycleStatus status{};
    Picoseconds period{};
  };

  void judge_master(std::uint64_t number, const Cycle& cycle);
  // A request that ended before its frame did, and how long a whole one takes.
  struct Aborted {
    std::uint64_t number = 0;
    Picoseconds begin{};
    Picoseconds whole{};
  };

  void judge_reset(std::uint64_t number, const Cycle& cycle);
  void judge_idle(std::uint64_t number, const Cycle& cycle);
  void judge_ready(std::uint64_t number, const Cycle& cycle, bool early);
  void judge_frame(std::uint64_t number, const Cycle& cycle);
  void judge_response(std::uint64_t number, const Cycle& cycle);
  void count_start(std::uint64_t number, CycleStatus status, Picoseconds period);
  void judge_bits(std::uint64_t number, const Cycle& cycle);
  void judge_times(std::uint64_t number, const Cycle& cycle);
  void judge_timeout(std::uint64_t number, const Cycle& cycle);

  DeviceTiming timing_;
  bool unidirectional_;
  Tallies& tallies_;
  LimitWatch limits_;
  // The longest request that was answered with a frame, in rising edges of MA.
  std::uint32_t usual_edges_ = 0;
  Unanswered unanswered_;
  std::optional<Aborted> aborted_;
  // The number of the previous cycle, if it is a good frame without STOP.
  std::optional<std::uint64_t> without_stop_;
  bool has_start_ = false;
  bool has_truncated_ = false;
  // The time by which SLO must be high again after the previous request.
  std::optional<Picoseconds> ready_by_;
  // The last ones that were measured.
  std::optional<Picoseconds> line_delay_;
  Picoseconds period_{};
};

}  // namespace biss::decode
