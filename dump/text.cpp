#include "dump/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace biss::dump {
namespace {

constexpr int end_of_text = std::char_traits<char>::eof();
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
    : stream_(stream), head_(std::move(head)) {
  if (std::string_view(head_).starts_with(byte_order_mark)) at_ = byte_order_mark.size();
}

int LineSource::peek() {
  return at_ < head_.size() ? static_cast<unsigned char>(head_[at_]) : stream_.peek();
}

int LineSource::take() {
  return at_ < head_.size() ? static_cast<unsigned char>(head_[at_++]) : stream_.get();
}

// A line ends in LF, CR and LF, or CR alone.
bool LineSource::next() {
  if (error_ || (peek() == end_of_text && !stream_.bad())) return false;
  ++number_;
  line_.clear();
  for (int c = take(); c != end_of_text && c != '\n'; c = take()) {
    if (c == '\r' && peek() != '\n') break;
    line_ += static_cast<char>(c);
    if (line_.size() <= max_line_bytes) continue;
    error_ = DumpError{DumpCause::line_too_long, number_};
    return false;
  }
  if (stream_.bad()) error_ = DumpError{DumpCause::read_failed, number_};
  return !error_;
}

std::string_view LineSource::next_row() {
  std::string_view row;
  while (row.empty() && next()) row = without_comment(line_);
  if (error_) throw *error_;
  return row;
}

DumpError LineSource::error_at(std::string_view place, DumpCause cause,
                               const char* expected) const {
  const auto column = static_cast<std::uint64_t>(place.data() - line_.data()) + 1;
  return {cause, number_, column, expected, {}};
}

}  // namespace biss::dump
