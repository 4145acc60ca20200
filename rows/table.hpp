// The rows of `biss decode`: which columns a format has, and a cycle's cells.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/safety/verdict.hpp"
#include "decode/cycle.hpp"
#include "decode/limits.hpp"
#include "report/table.hpp"
#include "rows/motion.hpp"

namespace biss::rows {

/// The columns of the command's contract: eleven fixed columns, the columns of the format, then
/// `marginal`, then `safety`, which is empty unless a monitor's verdict is given, then `limits`,
/// then the requested columns of Motion, then `frame` for a waveform.
class DecodeTable {
 public:
  /// Without a format only the eleven, `marginal`, `safety` and `limits`.
  /// \param format_varies the rows may be of captures with other formats
  /// \param frame_track a column with the parts of the frame as text
  explicit DecodeTable(const std::optional<FrameFormat>& format, bool format_varies = false,
                       MotionColumns motion = {}, bool frame_track = false);

  const std::vector<report::Column>& columns() const { return columns_; }
  /// The cells of a row, the time if the cycle is `timed`; they refer to `cycle` and are valid until the next call.
  const std::vector<report::Cell>& cells(std::uint64_t number, const decode::Cycle& cycle,
                                         std::optional<SafetyVerdict> safety = std::nullopt,
                                         decode::LimitSet limits = 0,
                                         const MotionValues& motion = {}, bool timed = true);

 private:
  report::Column integer(std::string name, unsigned bits, std::string unit) const;
  void add_value_columns(std::size_t k, unsigned position_bits);
  void add_channel_columns(std::size_t k, const ChannelFormat& channel);
  void add_motion_columns();
  static report::Cell* put_values(report::Cell* at, const ChannelFormat& channel,
                                  const Channel* values);
  report::Cell* put_channel(report::Cell* at, std::size_t k, const decode::Cycle& cycle) const;
  std::string frame_text(const decode::Cycle& cycle) const;

  std::optional<FrameFormat> format_;
  bool format_varies_;
  MotionColumns motion_;
  bool frame_track_;
  std::string frame_text_;
  std::size_t channels_ = 0;
  ChannelFormat first_channel_;
  std::vector<report::Column> columns_;
  std::vector<report::Cell> cells_;
  std::array<std::string, std::size_t{1} << decode::limit_count> limit_texts_;
};

}  // namespace biss::rows
