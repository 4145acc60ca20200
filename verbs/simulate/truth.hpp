// The rows of `biss simulate --truth`: the values that the encoder sent, and the faults of each
// cycle.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "report/table.hpp"
#include "sim/line.hpp"

namespace biss::verbs {

/// The columns are `cycle,time_ns,position,nE,nW,faults`, then position, nE and nW of each further
/// channel, then `places` (the places of faults in the cycle), `marginal` (our master sampled SLO
/// within 5 % of a period of a change) and `sampled_ns` (when the position of channel 1 was taken).
/// A value is empty if the channel does not have it, or if the channel's position was not sampled.
/// `marginal` is empty with a recorded master.
class TruthTable {
 public:
  /// \param changes the format changes: the last column is `format`
  explicit TruthTable(const FrameFormat& format, bool changes = false);

  /// From the next row on. \pre as many channels
  void set_format(const FrameFormat& format);

  const std::vector<report::Column>& columns() const { return columns_; }
  /// The cells of a row, valid until the next call.
  const std::vector<report::Cell>& cells(std::uint64_t number, const sim::SimulatedCycle& cycle);

 private:
  FrameFormat format_;
  std::vector<report::Column> columns_;
  std::vector<report::Cell> cells_;
  std::string faults_;
  std::string places_;
  std::string text_;  // of format_; empty: no such column
};

}  // namespace biss::verbs
