// Several captures as one: MA from one file, SLO from another.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "capture/edge_source.hpp"

namespace biss::capture {

/// A capture and its name, usually its path.
struct NamedSource {
  std::unique_ptr<EdgeSource> source;
  std::string name;
};

/// An EdgeSource over several, whose times must count from the same moment.
///
/// The lines of the first source come first, then the lines of the second, and so on. Each is
/// called `source:name`. Edges of the same time come in the order of the sources. When a source
/// fails, everything before the time it reached is delivered first, then its error. The end of
/// samples is known: if a source of samples ends before the others, its lines have no level from
/// there on. Lines of changes keep their last level.
class MergedSource final : public EdgeSource {
 public:
  /// \pre no source is null and none has been read from
  explicit MergedSource(std::vector<NamedSource> sources);

  const std::vector<std::string>& lines() const override { return lines_; }
  Result<std::span<const wire::Edge>, CaptureError> next_block() override;
  /// The largest of the sources' end times; after an error, the time up to which all of them were
  /// read.
  Picoseconds end_time() const override;
  /// The longest of the sources' sample periods.
  Picoseconds sample_period() const override;
  /// The rate of all sources; 0 Hz if they differ.
  Hertz sample_rate() const override;
  /// True if any source is analog.
  bool is_analog() const override;

  /// Which source the error of next_block() comes from.
  std::size_t failed_source() const { return failed_source_; }

 private:
  struct Input {
    std::unique_ptr<EdgeSource> source;
    wire::LineIndex first_line = 0;
    std::span<const wire::Edge> ahead;
    bool ended = false;
    // After the end of samples: no level on any line. The last edges ahead.
    std::vector<wire::Edge> unknown{};
  };

  static constexpr std::size_t block_edges = 8'192;

  bool fill();
  void end(Input& input);
  Input* earliest();
  Picoseconds read_to() const;

  std::vector<Input> inputs_;
  std::vector<std::string> lines_;
  std::vector<std::uint8_t> levels_;  // of the edges delivered, or no_level
  std::vector<wire::Edge> block_;
  Picoseconds last_{std::numeric_limits<std::int64_t>::min()};  // of the edges delivered
  bool failed_ = false;
  CaptureError error_;
  std::size_t failed_source_ = 0;
};

}  // namespace biss::capture
