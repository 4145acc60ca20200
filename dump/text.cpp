#include "dump/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace biss::dump {
namespace {

constexpr std::size_t block_bytes = 65'536;
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

struct CauseText {
  const char* name;
  const char* text;
};

constexpr auto causes = std::to_array<CauseText>({
    {"read_failed", "read error"},
    {"empty", "is empty"},
    {"unknown_format", "is text, but not a dump of registers"},
    {"malformed", "malformed"},
    {"line_too_long", "the line is too long"},
    {"not_whole_banks", "the size is not a multiple of 64 bytes"},
    {"outside", "there is no such register"},
    {"checksum", "the record's checksum is wrong"},
    {"contradiction", "this byte was given before, with another value"},
    {"several_slaves", "accesses to several slaves"},
    {"nothing_read", "no access that returned a byte"},
    {"truncated", "ends too early"},
});

// By DumpFormat.
constexpr std::array<const char*, 5> format_names{"binary banks of 64 bytes", "hex text",
                                                  "xxd or hexdump -C", "Intel HEX",
                                                  "JSON lines of accesses"};

}  // namespace

const char* name_of(DumpCause cause) { return causes[static_cast<std::size_t>(cause)].name; }

std::string dump_error_text(const DumpError& error) {
  std::string out;
  if (error.format) {
    out += fmt::format("read as {}: ", format_names[static_cast<std::size_t>(*error.format)]);
  }
  if (error.line != 0) out += fmt::format("line {}", error.line);
  if (error.line != 0 && error.column != 0) out += fmt::format(", column {}", error.column);
  if (error.line != 0) out += ": ";
  out += causes[static_cast<std::size_t>(error.cause)].text;
  if (error.expected != nullptr) out += fmt::format("; expected {}", error.expected);
  return out;
}

std::string_view first_row(std::string_view text) {
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    const std::string_view row = without_comment(text.substr(0, end));
    if (!row.empty()) return row;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

LineSource::LineSource(std::istream& stream, std::string head)
    : stream_(stream), buffer_(std::move(head)) {
  if (std::string_view(buffer_).starts_with(byte_order_mark)) at_ = byte_order_mark.size();
}

// The end of a line: LF, CR and LF, or CR alone; npos if more has to be read.
std::size_t LineSource::find_end(std::size_t from) const {
  const std::size_t end = buffer_.find_first_of("\r\n", from);
  if (end == std::string::npos || buffer_[end] == '\n') return end;
  if (end + 1 == buffer_.size()) return ended_ ? end : std::string::npos;
  return buffer_[end + 1] == '\n' ? end + 1 : end;
}

bool LineSource::next() {
  if (error_) return false;
  std::size_t feed = find_end(at_);
  while (feed == std::string::npos && buffer_.size() - at_ <= max_line_bytes && !ended_) {
    const std::size_t searched = buffer_.size() - at_;
    if (!fill()) return false;
    feed = find_end(searched - std::min<std::size_t>(searched, 1));
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

// Drops the lines that were read and reads a block; false when the stream fails.
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
  return {cause, number_, column, expected, {}};
}

}  // namespace biss::dump
