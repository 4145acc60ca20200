#include "capture/edge_writer.hpp"

#include <array>
#include <charconv>
#include <utility>

#include "capture/edge_source.hpp"

namespace biss::capture {
namespace {

constexpr std::size_t flush_bytes = 65'536;

}  // namespace

EdgeWriter::EdgeWriter(std::vector<std::string> lines, ByteSink& sink)
    : lines_(std::move(lines)), levels_(lines_.size(), no_level), sink_(&sink) {}

void EdgeWriter::append_number(std::uint64_t number) {
  std::array<char, 20> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
  text_.append(digits.data(), end);
}

// False and a cause when the edge cannot be written.
bool EdgeWriter::accept(const wire::Edge& edge) {
  failed_ = true;
  if (edge.line >= lines_.size()) {
    cause_ = WriteCause::no_such_line;
  } else if (any_ && edge.time < last_time_) {
    cause_ = WriteCause::time_backwards;
  } else if (edge.time < Picoseconds{} && !negative_times()) {
    cause_ = WriteCause::time_before_zero;
  } else {
    failed_ = false;
  }
  return !failed_;
}

void EdgeWriter::refuse(WriteCause cause) {
  failed_ = true;
  cause_ = cause;
}

bool EdgeWriter::flush_text(std::size_t limit) {
  if (failed_) return false;
  if (text_.size() < limit) return true;
  if (!sink_->write(text_)) {
    refuse(WriteCause::write_failed);
    return false;
  }
  text_.clear();
  return true;
}

bool EdgeWriter::flush_full() { return flush_text(flush_bytes); }

Written EdgeWriter::write(std::span<const wire::Edge> edges) {
  if (failed_) return failure(cause_);
  const std::uint64_t before = changes_;
  for (const wire::Edge& edge : edges) {
    if (!accept(edge)) return failure(cause_);
    const auto level = static_cast<std::uint8_t>(edge.level);
    if (levels_[edge.line] == level) continue;
    levels_[edge.line] = level;
    put(edge, !any_ || edge.time != last_time_);
    any_ = true;
    last_time_ = edge.time;
    ++changes_;
    if (!flush_full()) return failure(cause_);
  }
  return changes_ - before;
}

Written EdgeWriter::finish(Picoseconds end_time) {
  if (failed_) return failure(cause_);
  const bool sayable = negative_times() || end_time >= Picoseconds{};
  put_end(end_time, sayable && (!any_ || end_time > last_time_));
  if (!flush_text(0)) return failure(cause_);
  if (!sink_->flush()) {
    refuse(WriteCause::write_failed);
    return failure(cause_);
  }
  return changes_;
}

}  // namespace biss::capture
