// A stream of edges to a file: the shared part of the writers of all formats.
#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "biss/base/result.hpp"
#include "capture/bytes.hpp"
#include "capture/edge_source.hpp"
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
  Written write(std::span<const wire::Edge> edges) {
    const std::uint64_t before = changes_;
    for (const wire::Edge& edge : edges) {
      if (!failed_) failed_ = fault_of(edge);
      if (failed_) break;
      const auto level = static_cast<std::uint8_t>(edge.level);
      if (levels_[edge.line] == level) continue;
      levels_[edge.line] = level;
      put(edge, !any_ || edge.time != last_time_);
      any_ = true;
      last_time_ = edge.time;
      ++changes_;
      flush_full();
    }
    if (failed_) return failure(*failed_);
    return changes_ - before;
  }

  /// Writes what is held back, and that the capture lasts until `end_time` if that is later than
  /// the last edge. Returns the number of changes in the whole capture.
  Written finish(Picoseconds end_time) {
    if (failed_) return failure(*failed_);
    const bool sayable = negative_times() || end_time >= Picoseconds{};
    put_end(end_time, sayable && (!any_ || end_time > last_time_));
    if (flush_text(0) && !sink_->flush()) failed_ = WriteCause::write_failed;
    if (failed_) return failure(*failed_);
    return changes_;
  }

 protected:
  /// `lines` are the names, indexed by Edge::line.
  EdgeWriter(std::vector<std::string> lines, ByteSink& sink)
      : lines_(std::move(lines)), levels_(lines_.size(), no_level), sink_(&sink) {}

  /// One change; `new_time` when it is the first at its time.
  virtual void put(const wire::Edge& edge, bool new_time) = 0;
  /// Everything has been put; `later` when the capture lasts beyond the last change.
  virtual void put_end(Picoseconds end_time, bool later) = 0;
  virtual bool negative_times() const = 0;

  const std::vector<std::string>& lines() const { return lines_; }
  std::string& text() { return text_; }

  void append_number(std::uint64_t number) {
    std::array<char, 20> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    text_.append(digits.data(), end);
  }

  /// Hands text() on once there is enough of it; for formats in which one change is a lot of text.
  /// False when that failed or anything has failed before.
  bool flush_full() { return flush_text(flush_bytes); }

  /// Fails this call and every later one with `cause`.
  void refuse(WriteCause cause) { failed_ = cause; }

 private:
  static constexpr std::size_t flush_bytes = 65'536;

  // Why the edge cannot be written.
  std::optional<WriteCause> fault_of(const wire::Edge& edge) const {
    if (edge.line >= lines_.size()) return WriteCause::no_such_line;
    if (any_ && edge.time < last_time_) return WriteCause::time_backwards;
    if (edge.time < Picoseconds{} && !negative_times()) return WriteCause::time_before_zero;
    return std::nullopt;
  }

  bool flush_text(std::size_t limit) {
    if (failed_) return false;
    if (text_.size() < limit) return true;
    if (!sink_->write(text_)) failed_ = WriteCause::write_failed;
    text_.clear();
    return !failed_;
  }

  std::vector<std::string> lines_;
  std::vector<std::uint8_t> levels_;
  ByteSink* sink_;
  std::string text_;
  bool any_ = false;
  Picoseconds last_time_;
  std::uint64_t changes_ = 0;
  std::optional<WriteCause> failed_;
};

}  // namespace biss::capture
