// The rows of `biss decode`: which columns a format has, and a cycle's cells.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/safety/verdict.hpp"
#include "decode/cycle.hpp"
#include "decode/limits.hpp"
#include "report/table.hpp"

namespace biss::cli {

/// The columns of the command's contract: eleven that never change, those that the format adds,
/// then `marginal`, then `safety`, which is empty unless a monitor's verdict is given, then `limits`.
class DecodeTable {
 public:
  /// Without a format only the eleven, `marginal`, `safety` and `limits`.
  explicit DecodeTable(const std::optional<FrameFormat>& format);

  const std::vector<report::Column>& columns() const { return columns_; }
  /// The cells of a row; they refer to `cycle` and are valid until the next call.
  const std::vector<report::Cell>& cells(std::uint64_t number, const decode::Cycle& cycle,
                                         std::optional<SafetyVerdict> safety = std::nullopt,
                                         decode::LimitSet limits = 0);

 private:
  void add_channel_columns(std::size_t k, const ChannelFormat& channel);
  void add_channel_cells(std::size_t k, const decode::Cycle& cycle);
  void add_values(std::size_t k, const decode::Cycle& cycle);

  std::optional<FrameFormat> format_;
  std::vector<report::Column> columns_;
  std::vector<report::Cell> cells_;
  std::string limits_;
};

}  // namespace biss::cli
