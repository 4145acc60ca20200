#include "dump/line_source.hpp"

#include <algorithm>
#include <utility>

namespace biss::dump {
namespace {
constexpr std::size_t block_bytes = 65'536;
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

LineSource::LineSource(std::istream& stream, std::string head)
    : stream_(stream), buffer_(std::move(head)) {
  if (std::string_view(buffer_).starts_with(byte_order_mark)) at_ = byte_order_mark.size();
}

bool LineSource::next() {
  if (error_) return false;
  std::size_t searched = at_;
  std::size_t feed = buffer_.find('\n', searched);
  while (feed == std::string::npos && buffer_.size() - at_ <= max_line_bytes && !ended_) {
    searched = buffer_.size() - at_;
    if (!fill()) return false;
    feed = buffer_.find('\n', searched);
  }
  const std::size_t end = std::min(feed, buffer_.size());
  if (end == at_ && feed == std::string::npos) return false;
  ++number_;
  line_ = std::string_view(buffer_).substr(at_, end - at_);
  if (line_.size() > max_line_bytes) {
    error_ = DumpError{DumpCause::line_too_long, number_};
    return false;
  }
  at_ = std::min(end + 1, buffer_.size());
  return true;
}

// Drops the lines that were read and takes a block; false when the stream fails.
bool LineSource::fill() {
  buffer_.erase(0, at_);
  at_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + block_bytes);
  stream_.read(buffer_.data() + kept, static_cast<std::streamsize>(block_bytes));
  buffer_.resize(kept + static_cast<std::size_t>(stream_.gcount()));
  if (stream_.bad()) {
    error_ = DumpError{DumpCause::read_failed, number_ + 1};
    return false;
  }
  ended_ = !stream_;
  return true;
}

DumpError LineSource::error_at(std::string_view place, DumpCause cause,
                               const char* expected) const {
  const auto column = static_cast<std::uint64_t>(place.data() - line_.data()) + 1;
  return {cause, number_, column, expected};
}

}  // namespace biss::dump
