// A stream of edges to a file: the shared part of the writers of all formats.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "biss/base/result.hpp"
#include "capture/bytes.hpp"
#include "wire/edge.hpp"

namespace biss::capture {

enum class WriteCause : std::uint8_t {
  write_failed,      ///< the sink, or a temporary file, cannot be written
  no_such_line,      ///< an edge of a line that the writer was not given
  time_backwards,    ///< an edge before the one already written
  time_before_zero,  ///< the format cannot hold a negative time
  too_many_lines,    ///< more lines than the format holds
  too_large,         ///< beyond the address range of the format
};

/// Number of changes written; edges that change nothing are left out and not counted.
using Written = Result<std::uint64_t, WriteCause>;

/// Writes one capture: any number of write(), then finish(). The sink outlives the writer. After an
/// error the bytes in the sink are not a capture, and every further call fails the same way.
class EdgeWriter {
 public:
  virtual ~EdgeWriter() = default;

  /// Appends edges in time order; levels as in EdgeSource.
  Written write(std::span<const wire::Edge> edges);
  /// Writes the changes that are held back, and the end of the capture at `end_time` if that is
  /// later than the last edge. Returns the number of changes in the whole capture.
  Written finish(Picoseconds end_time);

 protected:
  /// `lines` are the names, indexed by Edge::line.
  EdgeWriter(std::vector<std::string> lines, ByteSink& sink);

  /// One change; `new_time` when it is the first at its time.
  virtual void put(const wire::Edge& edge, bool new_time) = 0;
  /// Everything has been put; `later` when the capture lasts beyond the last change.
  virtual void put_end(Picoseconds end_time, bool later) = 0;
  virtual bool negative_times() const = 0;

  const std::vector<std::string>& lines() const { return lines_; }
  std::string& text() { return text_; }
  void append_number(std::uint64_t number);
  /// Passes text() on once there is enough of it; for formats in which one change is a lot of text.
  /// False when that failed or anything has failed before.
  bool flush_full();
  /// Fails this call and every later one with `cause`.
  void refuse(WriteCause cause);

 private:
  bool accept(const wire::Edge& edge);
  bool flush_text(std::size_t limit);

  std::vector<std::string> lines_;
  std::vector<std::uint8_t> levels_;
  ByteSink* sink_;
  std::string text_;
  bool any_ = false;
  Picoseconds last_time_;
  std::uint64_t changes_ = 0;
  bool failed_ = false;
  WriteCause cause_{};
};

}  // namespace biss::capture
