// The result of a frame when one bit outside its word is read wrong: an ACK bit, START, CDS or
// STOP. Exact shares of all positions, for the formats `posN,nE,nW,crc6` of an encoder without
// error.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "biss/frame/frame.hpp"
#include "tests/exhaustive/affine.hpp"

namespace exhaustive {

/// A frame with its true values (right), with other values (wrong), with nE = 0 and therefore not
/// used, or a cause. The causes have the numbers of biss::FrameError.
enum class Outcome : std::uint8_t {};
inline constexpr Outcome right{biss::frame_error_count};
inline constexpr Outcome wrong{biss::frame_error_count + 1};
inline constexpr Outcome untrusted{biss::frame_error_count + 2};
inline constexpr std::size_t outcome_count = biss::frame_error_count + 3;
constexpr Outcome outcome(biss::FrameError cause) {
  return static_cast<Outcome>(static_cast<std::uint8_t>(cause));
}
std::string name_of(Outcome outcome);

/// How many positions (of a total) have each outcome.
using Tally = std::array<std::uint64_t, outcome_count>;

/// Positions that share an outcome and the place at which START is seen.
struct Leaf {
  Outcome outcome{};
  std::size_t start_bit = 0;
  Positions positions;
};

/// One format, one true ACK, one reader; `flip` is the index of the bit read wrong.
struct Case {
  unsigned position_bits = 18;
  bool cds0 = false;
  biss::FrameBounds bounds{};
  std::size_t ack_clocks = 1;
  std::size_t flip = 0;
  /// The master continues the clock after STOP (SLO stays 0 then) instead of stopping at it.
  bool clock_goes_on = false;

  static constexpr std::size_t lead_clocks = 2;
  std::size_t start_bit() const { return lead_clocks + ack_clocks; }
  std::size_t stop_bit() const { return start_bit() + 2 + position_bits + 2 + 6; }
};

/// The bits on the line for all positions together, with the wrong bit.
AffineBits affine_line(const Case& what);

struct Verdict {
  Tally tally{};
  /// All outcomes except `crc`, which is the remainder.
  std::vector<Leaf> leaves;
};

/// The outcomes of all positions, by counting.
Verdict judge_all(const Case& what);

/// The bit that is read wrong; one table for each.
enum class Fault : std::uint8_t {
  ack_first,
  ack_between,
  ack_last_but_one,
  ack_last,
  start,
  start_clock_goes_on,
  cds,
  stop,
};
inline constexpr std::size_t fault_count = 8;

/// The readers of the table.
struct Setting {
  const char* limits;  ///< of ACK, as the table shows them
  biss::FrameBounds bounds;
  std::size_t ack_clocks;
};
const std::array<Setting, 4>& settings();

/// The cases of one row: several if the fault can be in several bits.
std::vector<Case> cases_of(Fault fault, const Setting& setting, unsigned position_bits, bool cds0);
/// The only ACK bit read as 1.
Case lone_ack_case(unsigned position_bits, bool cds0, bool clock_goes_on);

inline constexpr std::array<unsigned, 4> table_widths{18, 26, 32, 36};

/// The tables of lab/reports/flips.md, as Markdown.
std::string flip_tables();

}  // namespace exhaustive
