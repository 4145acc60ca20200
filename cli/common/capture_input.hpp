// The captures a verb reads: one or several files as one source, its beginning at hand for a look.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/edge_source.hpp"
#include "cli/common/exit_status.hpp"
#include "cli/common/raw_samples.hpp"

namespace biss::cli {

/// A capture opened from the command line.
class CaptureInput {
 public:
  /// Opens `files`; several make one capture with the lines of all. `ma` and `slo` may be `NAME` or
  /// `FILE:NAME`; a file named only there is opened too. Says on stderr why not: `usage` when no
  /// file is named, or `raw` is given and none of them is raw; `io` when one cannot be opened.
  ExitStatus open(std::vector<std::string> files, const std::string& ma, const std::string& slo,
                  const RawSamples& raw);

  /// `path` is one of the files opened, by whatever name. False for what is no regular file.
  bool reads(const std::string& path) const;

  const std::vector<std::string>& lines() const { return source_->lines(); }
  /// The name in lines() that `NAME` or `FILE:NAME` stands for; the text itself where there is
  /// none.
  std::string line_of(const std::string& text) const;

  /// Reads ahead until that many edges are at hand or the capture ends; they are delivered by
  /// next() all the same.
  std::span<const wire::Edge> look_at_beginning(std::size_t edges);

  /// The next edges; empty at the end, or when reading failed: then error() is not empty.
  std::span<const wire::Edge> next();

  Picoseconds end_time() const { return source_->end_time(); }
  /// As EdgeSource::sample_period().
  Picoseconds sample_period() const { return source_->sample_period(); }
  /// One line, empty while all is well.
  const std::string& error() const { return error_; }
  /// What the user called it.
  std::string name() const;

 private:
  std::span<const wire::Edge> pull();

  std::vector<std::string> files_;
  std::vector<std::size_t> first_line_;
  std::unique_ptr<capture::EdgeSource> source_;
  std::vector<wire::Edge> beginning_;
  bool beginning_pending_ = false;
  bool ended_ = false;
  std::string error_;
};

}  // namespace biss::cli
