// The capture that `biss simulate` writes, and the rows that belong to its cycles.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "report/table.hpp"
#include "verbs/common/capture_output.hpp"
#include "verbs/common/fields.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

/// A capture, and a table as CSV. After the first failure nothing more is written.
class LineOutput {
 public:
  explicit LineOutput(Host& host) : host_(host) {}

  /// \param names of the lines
  /// \param sample_rate of a capture of samples; empty: chosen by the clock
  /// \param rows_path empty: no rows
  bool open(const std::string& path, const std::vector<std::string>& names, Hertz clock,
            const std::optional<Hertz>& sample_rate, const std::string& rows_path,
            std::span<const report::Column> columns) {
    if (!output_.open(path)) return false;
    if (!rows_path.empty()) {
      if (!rows_output_.open(rows_path)) return false;
      rows_ = report::make_table_writer(report::Format::csv, columns, rows_output_);
    }
    edges_.emplace(capture_format_of(path).value_or(CaptureFormat::vcd), names,
                   sample_rate.value_or(usual_sample_rate(clock)), output_);
    if (sample_rate) warn_of_lost_clocks(*sample_rate, clock, host_);
    return true;
  }

  void row(std::span<const report::Cell> cells) {
    if (rows_) good_ = rows_->row(cells) && good_;
  }
  void row(const FieldRow& fields) {
    if (rows_) good_ = write_row(*rows_, fields) && good_;
  }
  /// False when any output failed, rows included.
  bool write(std::span<const wire::Edge> edges) {
    good_ = good_ && edges_->write(edges);
    return good_;
  }
  bool finish(Picoseconds end) {
    if (!good_ || !edges_->finish(end) || !output_.finish()) return false;
    return !rows_ || (rows_->finish() && rows_output_.finish());
  }

  bool has_rows() const { return rows_ != nullptr; }
  /// The reader of the capture has left.
  bool reader_left() const { return output_.reader_left(); }
  /// Prints what failed.
  ExitStatus status() const {
    if (edges_ && edges_->status() != ExitStatus::done) return ExitStatus::io;
    if (output_.status() != ExitStatus::done) return ExitStatus::io;
    return rows_output_.status();
  }

 private:
  Host& host_;
  Output output_{host_};
  Output rows_output_{host_};
  std::optional<CaptureOutput> edges_;
  std::unique_ptr<report::TableWriter> rows_;
  bool good_ = true;
};

}  // namespace biss::verbs
