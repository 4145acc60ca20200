#include "dump/read.hpp"

#include <algorithm>
#include <utility>

#include "dump/readers.hpp"

namespace biss::dump {
namespace {

bool is_text(std::string_view bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 0x20 ? c != '\x7F' : is_blank(c) || c == '\n';
  });
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
  if (!is_text(head) || row.empty()) return DumpFormat::binary;
  if (const auto format = format_of_row(row)) return format;
  // The bytes of a few banks may all be printable characters, but not the bytes of 64 banks.
  const bool banks = head.size() % bank_bytes == 0 && head.size() < head_bytes;
  return banks ? std::optional(DumpFormat::binary) : std::nullopt;
}

DumpResult read_dump(std::istream& stream, std::string head, const DumpOptions& options) {
  if (stream.bad()) return tl::unexpected(DumpError{DumpCause::read_failed});
  const bool blank = is_text(head) && first_row(head).empty() && head.size() < head_bytes;
  if (head.empty() || blank) return tl::unexpected(DumpError{DumpCause::empty});
  const auto format = recognise(head);
  if (!format) return tl::unexpected(DumpError{DumpCause::unknown_format});
  try {
    if (*format == DumpFormat::binary) return read_binary(stream, std::move(head), options);
    LineSource lines(stream, std::move(head));
    return read_text(*format, lines, options);
  } catch (DumpError& error) {
    error.format = format;
    return tl::unexpected(error);
  }
}

RegisterDump read_binary(std::istream& stream, std::string head, const DumpOptions& options) {
  std::string bytes = std::move(head);
  const std::size_t had = bytes.size();
  bytes.resize(std::max(had, image_bytes + 1));  // one more than there may be
  stream.read(bytes.data() + had, static_cast<std::streamsize>(bytes.size() - had));
  if (stream.bad()) throw DumpError{DumpCause::read_failed};
  bytes.resize(had + static_cast<std::size_t>(stream.gcount()));
  RegisterDump dump;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    auto* const at = byte_at_offset(dump, i, options);
    if (at == nullptr) throw DumpError{DumpCause::outside, 0, 0, "at most 256 banks", {}};
    *at = static_cast<std::uint8_t>(bytes[i]);
  }
  if (bytes.size() % bank_bytes != 0) throw DumpError{DumpCause::not_whole_banks};
  return dump;
}

}  // namespace biss::dump
