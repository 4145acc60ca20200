// The oracle's slave: computes SLO from the complete MA by counting edges. It has no stepping and
// no state between requests.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "tests/oracle/oracle.hpp"

namespace oracle {

/// Picoseconds.
using Time = long long;

struct Change {
  Time time = 0;
  bool level = false;

  bool operator==(const Change&) const = default;
};

/// Every change of a line that begins high, in time order, with alternating levels.
using Line = std::vector<Change>;

enum class TimeoutKind { adaptive, fixed, cycle };

struct SlaveDescription {
  Time sampling = 0;           ///< from the first rising edge of MA
  Time start_min = 0;          ///< from the first rising edge to START
  Time ready = 0;              ///< from the second rising edge until there is an answer
  std::size_t ack_clocks = 0;  ///< instead of start_min and ready; 0: not fixed
  std::size_t busy_clocks = 0;
  TimeoutKind kind = TimeoutKind::fixed;
  Time timeout = 40'000'000;
  Time static_timeout = 40'000'000;
  Time release_halves = 3;  ///< kind `cycle`: SLO low after the last edge, in half periods of MA
  bool chained = false;
};

struct SlaveAnswer {
  Line slo;
  std::vector<Time> samples;
  std::vector<Change> cdm;  ///< when it was read, and the bit
};

/// The bits of all channels, CRCs included, for the sampling with this number (0, 1, …).
using PayloadOf = std::function<Bits(std::size_t)>;

/// \param sli not looked at unless the slave is chained
SlaveAnswer answer(const SlaveDescription& slave, const Line& ma, const Line& sli,
                   const PayloadOf& payload, bool cds);

}  // namespace oracle
