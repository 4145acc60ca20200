// Where a verb's edges go: a capture in the format that the file's extension names.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "biss/base/units.hpp"
#include "capture/edge_writer.hpp"
#include "cli/common/output.hpp"

namespace biss::cli {

/// Writes edges to an Output, which outlives it: `.sr` a sigrok session, `.bin` and `.raw` raw
/// samples, `.saleae.csv` the CSV of Saleae Logic, any other `.csv` event CSV, anything else VCD.
class CaptureOutput final : public capture::ByteSink {
 public:
  /// `sample_rate` is for the sampled formats: the first two.
  /// \pre at most 64 lines; sample_rate is not 0 Hz
  CaptureOutput(const std::string& path, const std::vector<std::string>& lines, Hertz sample_rate,
                Output& output);
  CaptureOutput(const CaptureOutput&) = delete;
  CaptureOutput& operator=(const CaptureOutput&) = delete;

  /// As EdgeWriter has them; false when it failed, status() says how the verb ends then.
  bool write(std::span<const wire::Edge> edges);
  bool finish(Picoseconds end_time);
  /// Says on stderr why writing failed, unless only the reader left.
  ExitStatus status() const;

  /// Whether a file of that name is sampled.
  static bool is_sampled(const std::string& path);

 private:
  bool write(std::string_view bytes) override { return output_.write(bytes); }
  bool flush() override { return true; }
  bool take(const capture::Written& written);

  Output& output_;
  std::unique_ptr<capture::EdgeWriter> writer_;
  std::optional<capture::WriteCause> cause_;
};

/// A rate that analysers have, to sample a clock with: the next of 1, 2 and 5 times a power of ten
/// from eight times the clock on; 4 GHz at most. Each has a period of whole picoseconds.
Hertz usual_sample_rate(Hertz clock);

}  // namespace biss::cli
