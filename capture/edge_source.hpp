// The one shape in which every capture reaches the decoder: named lines and blocks of edges in time
// order. Changes are never expanded into samples.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "biss/base/result.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

/// Longer words of VCD and rows of CSV are refused, so that memory stays bounded.
inline constexpr std::size_t max_token_bytes = 65'536;
/// The most one-bit signals of a capture.
inline constexpr std::size_t max_lines = 65'536;

/// Why a capture could not be read, or not read further. One enumerator for each cause;
/// capture_error_text() gives the line that the user sees.
enum class CaptureCause : std::uint8_t {
  cannot_open,        ///< missing, no permission
  is_directory,       ///< the path names a folder
  read_failed,        ///< the system could not read further
  empty,              ///< no byte, or only white space
  unknown_format,     ///< neither the extension nor the content is known
  compression,        ///< a compression that is not supported
  malformed,          ///< a token, number or header that the format does not allow
  token_too_long,     ///< a token (or CSV line) longer than any valid one
  too_many_lines,     ///< more signals than a capture may have
  block_too_large,    ///< a part that has to be in memory at once takes more than 256 MiB
  time_backwards,     ///< a time before the previous one
  time_out_of_range,  ///< a time beyond what 64-bit picoseconds hold
  damaged,            ///< an archive or its compressed data is incomplete or damaged
  too_large,          ///< a compressed archive that is too large for a temporary file
  layout_missing,     ///< raw samples, and no layout given for them
  bad_layout,         ///< the layout given for raw samples is not possible
  no_two_levels,      ///< no analog channel has two levels, so there is no threshold
  no_such_channel,    ///< a differential that does not name two analog channels of the capture
  truncated,          ///< the file ends inside a token, a header, a row or a sample
};

/// The place and the cause at which reading stopped. `line` and `column` count from 1, columns in
/// bytes; `line` is 0 when the cause is not in the text. `expected` describes valid content at that
/// place: static text, or null. `part` names the part of an archive: static text, or null; its
/// `part_number` counts from 1 and is 0 if parts have no number. `member` is the name of a member
/// that is refused: printable characters up to a 0, cut if it is long.
struct CaptureError {
  CaptureCause cause{};
  std::uint64_t line = 0;
  std::uint64_t column = 0;
  const char* expected = nullptr;
  const char* part = nullptr;
  std::uint64_t part_number = 0;
  std::array<char, 40> member = {};
};

class PairSource;

/// A capture of changes, read once from front to back.
///
/// Edges come in time order; the first edge of a line gives its initial level, every later one
/// changes it. Everything before an error is delivered by earlier calls, so only the damaged end is
/// lost. Memory is bounded by the block size and the number of lines, never by the length of the
/// file.
class EdgeSource {
 public:
  virtual ~EdgeSource() = default;

  /// Names of the lines, indexed by Edge::line; no two are equal. Known after opening and constant
  /// from then on.
  virtual const std::vector<std::string>& lines() const = 0;

  /// The next edges, valid until the next call; empty at the end of the capture. After an error or
  /// the end every further call returns the same.
  virtual Result<std::span<const wire::Edge>, CaptureError> next_block() = 0;

  /// The last time in the capture (a VCD may end with a time and no change); grows while reading.
  virtual Picoseconds end_time() const = 0;

  /// The longest time between two samples; 0 if the file holds changes. A change has the time of
  /// the first sample that shows it. For analog samples the time is interpolated between two
  /// samples. It is still certain only to this period, because the signal may have changed anywhere
  /// in it.
  virtual Picoseconds sample_period() const { return {}; }

  /// The rate of the samples; 0 Hz if the file holds changes, or if its rate is not known, is not a
  /// whole number of hertz, or varies.
  virtual Hertz sample_rate() const { return {}; }

  /// These are raw samples, read by the layout that the caller gave.
  virtual bool is_raw() const { return false; }

  /// Some lines are voltages, compared with a threshold.
  virtual bool is_analog() const { return false; }

  /// The rest of the capture, after the last next_block(), as arrays of the changes of these two
  /// lines. It is null if this source reads edges only. Do not call next_block() afterwards. This
  /// object must outlive the pairs.
  virtual std::unique_ptr<PairSource> pairs(wire::LineIndex ma, wire::LineIndex slo);
};

/// An opened capture, or why it cannot be read.
using Opened = tl::expected<std::unique_ptr<EdgeSource>, CaptureError>;

/// A line's last level as a number; `no_level` before its first edge.
inline constexpr std::uint8_t no_level = 3;

/// The edges of one block. full() is true long before it overflows: a row, a value or a sample may
/// push one edge a line.
class EdgeBlock {
 public:
  /// `lines` edges always fit after the last one for which full() was false.
  void prepare(std::size_t lines) {
    count_ = 0;
    edges_.resize(limit_ + lines);
  }
  bool full() const { return count_ >= limit_; }
  bool empty() const { return count_ == 0; }
  void push(wire::Edge edge) { edges_[count_++] = edge; }
  std::span<const wire::Edge> edges() const { return std::span(edges_).first(count_); }
  /// Lets the next block be larger when this one was full.
  void grow() {
    if (full() && limit_ < max_limit) limit_ *= 2;
  }

 private:
  static constexpr std::size_t max_limit = 8'192;

  std::size_t limit_ = 128;
  std::size_t count_ = 0;
  std::vector<wire::Edge> edges_;
};

/// An EdgeSource whose edges come in blocks: a format adds step().
class StepSource : public EdgeSource {
 public:
  const std::vector<std::string>& lines() const final { return lines_; }
  Picoseconds end_time() const override { return end_time_; }
  Result<std::span<const wire::Edge>, CaptureError> next_block() final;

 protected:
  /// The names of the lines, which become unique_names(), before the first step. Two edges a line fit
  /// into a block that is not full.
  void set_lines(std::vector<std::string> lines);
  /// Reads on and pushes edges into block_, or calls finish() or fail(). Called again while there are
  /// no edges.
  virtual void step() = 0;

  void finish() { ended_ = true; }
  /// Ends reading with an error, to be returned after the edges that came before it.
  void fail(const CaptureError& error) {
    error_ = error;
    ended_ = true;
  }
  bool ended() const { return ended_; }
  const std::optional<CaptureError>& error() const { return error_; }
  /// Makes the block empty again.
  void renew_block();

  EdgeBlock block_;
  Picoseconds end_time_;

 private:
  std::vector<std::string> lines_;
  bool delivered_ = false;
  bool ended_ = false;
  std::optional<CaptureError> error_;
};

/// The names with a number after each that an earlier one equals: the second `MA` is `MA#2`, or the
/// first free of `MA#3`, `MA#4`, …
std::vector<std::string> unique_names(std::vector<std::string> names);

}  // namespace biss::capture
