#include "dump/read.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <utility>

#include "dump/hex_digits.hpp"

namespace biss::dump {
namespace {

// The first line that is neither blank nor a comment.
std::string_view first_row(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view row = trimmed(text.substr(0, end));
    if (!row.empty() && row.front() != '#') return row;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

bool is_text(std::string_view bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 ? c != '\x7F' : is_blank(c) || c == '\n';
  });
}

std::size_t hex_digits_at_front(std::string_view row) {
  const auto* const end =
      std::find_if(row.begin(), row.end(), [](char c) { return hex_value(c) < 0; });
  return static_cast<std::size_t>(end - row.begin());
}

std::optional<DumpFormat> format_of_row(std::string_view row) {
  if (row.starts_with('{')) return DumpFormat::json_lines;
  if (row.starts_with(':') && hex_digits_at_front(row.substr(1)) >= 8) return DumpFormat::intel_hex;
  if (row.starts_with("0x") || row.starts_with("0X")) return DumpFormat::hex_page;
  std::string_view rest = row;
  if (next_word(rest) == "bank") return DumpFormat::hex_page;
  const std::size_t digits = hex_digits_at_front(row);
  const bool ended = digits == row.size() || row[digits] == ':' || is_blank(row[digits]);
  if (digits >= 4 && digits <= 8 && ended) return DumpFormat::hex_offsets;
  return std::nullopt;
}

}  // namespace

std::string read_head(std::istream& stream) {
  std::string head(head_bytes, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  return head;
}

std::optional<DumpFormat> recognise(std::string_view head) {
  const std::string_view row = first_row(head);
  if (is_text(head) && !row.empty()) {
    if (const auto format = format_of_row(row)) return format;
    // Bytes of a bank may all happen to be letters; a text that is not ours is seldom as long.
    return head.size() % bank_bytes == 0 ? std::optional(DumpFormat::binary) : std::nullopt;
  }
  return DumpFormat::binary;
}

DumpResult read_dump(std::istream& stream, std::string head, const DumpOptions& options) {
  if (stream.bad()) return failure(DumpError{DumpCause::read_failed});
  if (head.empty()) return failure(DumpError{DumpCause::empty});
  if (is_text(head) && first_row(head).empty() && head.size() < head_bytes) {
    return failure(DumpError{DumpCause::empty});
  }
  const auto format = recognise(head);
  if (!format) {
    return failure(DumpError{DumpCause::unknown_format, 0, 0,
                             "banks of 64 bytes, hex text, Intel HEX or JSON lines of accesses"});
  }
  if (*format == DumpFormat::binary) return read_binary(stream, std::move(head), options);
  LineSource lines(stream, std::move(head));
  switch (*format) {
    case DumpFormat::hex_page:
      return read_hex_page(lines, options);
    case DumpFormat::hex_offsets:
      return read_hex_offsets(lines, options);
    case DumpFormat::intel_hex:
      return read_intel_hex(lines, options);
    default:
      return read_json_lines(lines, options);
  }
}

DumpResult read_dump_file(const std::string& path, const DumpOptions& options) {
  if (path == "-") return read_dump(std::cin, read_head(std::cin), options);
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) {
    return failure(DumpError{DumpCause::is_directory});
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return failure(DumpError{DumpCause::cannot_open});
  return read_dump(file, read_head(file), options);
}

}  // namespace biss::dump
