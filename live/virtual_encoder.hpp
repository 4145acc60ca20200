// An encoder at the end of its cable, in the time of its master, and the commands that change it
// while it runs.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "biss/base/units.hpp"
#include "sim/far_end.hpp"

namespace biss::live {

class VirtualEncoder {
 public:
  using OnRequest = std::function<void(const sim::FarEndCycle& request)>;

  /// \pre as for FarEnd; the rules of the setup are of kinds with is_of_far_end()
  /// \param on_request gets each request when it is complete: when the next one begins, or at
  /// finish()
  VirtualEncoder(const sim::FarEndSetup& setup, OnRequest on_request);

  /// MA has this level from now on. \pre times of all calls do not decrease
  void put_ma(Picoseconds now, bool ma);
  /// SLO at the master now.
  bool slo(Picoseconds now) { return far_.step(now, ma_, true).slo; }
  /// There are no more requests. Call it once.
  void finish(Picoseconds now);

  /// Executes one command; the answer is one line, `ok …` or `error: …`:
  ///   fault KIND@next[,PLACE] · fault KIND:RATE[,PLACE] · fault off
  ///   at N · move N · motion KIND · nE 0|1 · nW 0|1
  ///   unplug · plug · power off|on · status
  /// `status` answers with one JSON object after `ok`.
  std::string command(std::string_view line, Picoseconds now);

 private:
  std::string set_fault(const std::string& text);
  std::string set_position(std::string_view text, bool relative, Picoseconds now);
  std::string set_flag(bool& flag, std::string_view text);
  std::string status(Picoseconds now);
  void put_request(const sim::FarEndCycle& request);

  sim::FarEnd far_;
  OnRequest on_request_;
  std::vector<sim::FaultRule> rules_;
  unsigned position_bits_;
  bool ma_ = true;
  bool nE_ = true;
  bool nW_ = true;
  bool plugged_ = true;
  bool powered_ = true;
  std::uint64_t seen_ = 0;  // requests that have begun
  std::uint64_t damaged_ = 0;
  sim::FaultSet last_faults_ = 0;  // of the last request that had any
};

}  // namespace biss::live
