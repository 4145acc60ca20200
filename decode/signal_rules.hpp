// Rules on the signals of MA and SLO: levels, pulses, line delay, sampling.
#pragma once

#include <cstdint>
#include <optional>

#include "biss/base/units.hpp"
#include "biss/timing/device_timing.hpp"
#include "decode/cycle.hpp"
#include "decode/rules.hpp"

namespace biss::decode {

class SignalRules {
 public:
  struct Setup {
    DeviceTiming timing;
    bool renishaw_cables = false;
    bool compensated = true;
  };
  SignalRules(const Setup& setup, Tallies& tallies);

  /// \param cycle with Cycle::signal; without it only the line delay is judged
  void push(std::uint64_t number, const Cycle& cycle);

 private:
  void judge_ma(std::uint64_t number, const Cycle& cycle);
  void judge_pulses(std::uint64_t number, const Cycle& cycle);
  void judge_clocks(std::uint64_t number, const Cycle& cycle);
  void judge_changes(std::uint64_t number, const Cycle& cycle);
  void judge_sampling(std::uint64_t number, const Cycle& cycle);
  void judge_delay(std::uint64_t number, const Cycle& cycle);
  void judge_cable(std::uint64_t number, const Cycle& cycle);
  std::optional<Picoseconds> clocks_end(const Cycle& cycle, Picoseconds frame_end) const;

  Setup setup_;
  Tallies& tallies_;
  // The line delays of the capture so far.
  std::optional<Picoseconds> least_delay_;
  Picoseconds most_delay_{};
};

}  // namespace biss::decode
