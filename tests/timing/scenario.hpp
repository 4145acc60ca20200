// Slaves in a daisy chain with stimuli, simulated by the core and by the oracle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/frame/frame.hpp"
#include "biss/slave/slave.hpp"
#include "tests/oracle/slave.hpp"

namespace timing_test {

/// A slave with one channel: position and CRC.
struct Device {
  unsigned position_bits = 3;
  unsigned crc_bits = 3;  ///< 3 or 6, the usual polynomial of that width
  std::uint64_t position = 0;
  /// The position of sampling n (0, 1, …) is `position` with these bits of n inverted.
  std::uint64_t changing = 0;
  bool cds = false;
  oracle::SlaveDescription timing;
};

/// Slave 0 first. Only further ones are chained.
struct Scenario {
  std::vector<Device> chain;
  oracle::Line ma;
};

/// The results of each slave, in the order of the chain.
using Answers = std::vector<oracle::SlaveAnswer>;

/// A slave of the core.
struct CoreSlave {
  biss::FrameFormat format;
  biss::SlaveTiming timing;
  /// The content of sampling n (0, 1, …).
  std::function<biss::Frame(std::size_t)> frame;
  bool cds = false;
};

/// Steps the core's slaves at each edge of MA and at each deadline.
Answers answers_of_core(const std::vector<CoreSlave>& slaves, const oracle::Line& edges);
Answers answers_of_core(const Scenario& scenario);
Answers answers_of_oracle(const Scenario& scenario);

/// The first difference of a slave; empty if there is none.
std::string difference(const Answers& first, const Answers& second);

/// All changes on one line, times in ns.
std::string text_of(const oracle::Line& line);

}  // namespace timing_test
