// Lines of a stream, one by one, in bounded memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>

#include "dump/dump_error.hpp"

namespace biss::dump {

/// Longer lines are refused: the longest that `biss registers --to jsonl` writes has some hundreds.
inline constexpr std::size_t max_line_bytes = 16'384;

/// White space inside a line.
constexpr bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }
std::string_view trimmed(std::string_view text);

class LineSource {
 public:
  /// `head` is what was read of the stream already, to look at it. The stream must outlive the
  /// source.
  LineSource(std::istream& stream, std::string head);

  /// Goes on to the next line; false at the end, and where error() is set: `line_too_long`,
  /// `read_failed`.
  bool next();
  /// Without its line feed; valid until next().
  std::string_view line() const { return line_; }
  /// From 1.
  std::uint64_t number() const { return number_; }
  const std::optional<DumpError>& error() const { return error_; }

  /// An error at a place in line(), which `place` is a part of.
  DumpError error_at(std::string_view place, DumpCause cause, const char* expected = nullptr) const;

 private:
  bool fill();

  std::istream& stream_;
  std::string buffer_;
  std::size_t at_ = 0;
  std::string_view line_;
  std::uint64_t number_ = 0;
  bool ended_ = false;
  std::optional<DumpError> error_;
};

}  // namespace biss::dump
