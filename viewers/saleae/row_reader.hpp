// Changes of MA and SLO by their sample numbers in, rows of `biss decode` out. It does not use
// Saleae's software.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "biss/frame/format.hpp"
#include "biss/timing/device_timing.hpp"
#include "capture/samples.hpp"
#include "decode/decoder.hpp"
#include "decode/limits.hpp"
#include "rows/table.hpp"

namespace biss::saleae {

/// The user's settings of the encoder and the lines.
struct RowSetup {
  /// Empty: the structure alone is read.
  std::optional<FrameFormat> format;
  DeviceTiming timing;
  bool ma_inverted = false;
  bool slo_inverted = false;
};

/// Sets format and timing: items in line order, the name of an encoder or of a safety configuration,
/// or `none`. The error is one line; the setup is then as before.
tl::expected<void, std::string> set_format(RowSetup& setup, std::string_view format);

/// A row and the samples of its first and last edge of MA.
struct Row {
  CycleStatus status{};
  /// Both are valid during the call that delivers the row.
  const std::vector<report::Column>& columns;
  const std::vector<report::Cell>& cells;
  std::uint64_t first_sample = 0;
  std::uint64_t last_sample = 0;
};

/// Columns and values are the same as in `biss decode --safety off`.
class RowReader {
 public:
  using OnRow = std::function<void(const Row&)>;

  /// \pre rate is not 0 Hz
  RowReader(const RowSetup& setup, Hertz rate, OnRow on_row);

  /// Changes in the order of time; the first one of a line gives its level at the beginning.
  /// Changes after the last sample that has a time are ignored.
  void push_ma(std::uint64_t sample, bool level) { push(ma_line, sample, level); }
  void push_slo(std::uint64_t sample, bool level) { push(slo_line, sample, level); }

  /// MA rests up to this sample: delivers the last request, which the decoder keeps until it has
  /// seen the next one.
  void rest_until(std::uint64_t sample);

 private:
  static constexpr wire::LineIndex ma_line = 0;
  static constexpr wire::LineIndex slo_line = 1;

  void push(wire::LineIndex line, std::uint64_t sample, bool level);
  void deliver();
  void deliver(const decode::Cycle& cycle);

  capture::SampleClock clock_;
  decode::Lines lines_;
  OnRow on_row_;
  rows::DecodeTable table_;
  decode::LimitWatch limits_;
  // A row is complete with the next one: no row is shown while the line rests.
  bool needs_next_ = false;
  // Shared by the decoder and by the copies of it that rest_until() ends.
  std::shared_ptr<std::vector<decode::Cycle>> cycles_;
  decode::Decoder decoder_;
  std::uint64_t number_ = 0;
  // Rows that a copy has delivered before the decoder.
  std::uint64_t ahead_ = 0;
};

}  // namespace biss::saleae
