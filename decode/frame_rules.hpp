// Rules on a single request and its frame: limits of the master, structure, times.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/limits.hpp"
#include "decode/rules.hpp"

namespace biss::decode {

/// The device could not answer such a request in full, or the capture does not show it.
bool is_no_evidence(CycleStatus status);
/// START was found, and MA ran as it should.
bool has_times(CycleStatus status);

class FrameRules {
 public:
  /// \param unidirectional CDS is always 0
  FrameRules(const DeviceTiming& timing, bool unidirectional, Tallies& tallies);

  void push(std::uint64_t number, const Cycle& cycle);

 private:
  void judge_master(std::uint64_t number, const Cycle& cycle);
  void judge_idle(std::uint64_t number, const Cycle& cycle);
  void judge_ready(std::uint64_t number, const Cycle& cycle, bool early);
  void judge_frame(std::uint64_t number, const Cycle& cycle);
  void judge_bits(std::uint64_t number, const Cycle& cycle);
  void judge_times(std::uint64_t number, const Cycle& cycle);
  void judge_timeout(std::uint64_t number, const Cycle& cycle);

  DeviceTiming timing_;
  bool unidirectional_;
  Tallies& tallies_;
  LimitWatch limits_;
  // The longest request that was answered with a frame, in rising edges of MA.
  std::uint32_t usual_edges_ = 0;
  // Of the request before: SLO is due to be high again by then.
  std::optional<Picoseconds> ready_by_;
  // The last one that was measured.
  std::optional<Picoseconds> line_delay_;
};

}  // namespace biss::decode
