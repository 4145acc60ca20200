#include "dump/dump_error.hpp"

#include <fmt/format.h>

#include <array>

namespace biss::dump {
namespace {

struct CauseText {
  const char* name;
  const char* text;
};

constexpr std::array<CauseText, 14> causes{{
    {"cannot_open", "cannot be opened"},
    {"is_directory", "is a folder"},
    {"read_failed", "cannot be read on"},
    {"empty", "holds nothing"},
    {"unknown_format", "is no dump of registers"},
    {"malformed", "malformed"},
    {"line_too_long", "the line is too long"},
    {"not_whole_banks", "the size is no multiple of 64 bytes"},
    {"outside", "there is no such register"},
    {"checksum", "the record's checksum is wrong"},
    {"contradiction", "this byte was given before, with another value"},
    {"several_slaves", "accesses to several slaves"},
    {"nothing_read", "no access that brought a byte"},
    {"truncated", "ends too early"},
}};

}  // namespace

const char* name_of(DumpCause cause) { return causes[static_cast<std::size_t>(cause)].name; }

std::string dump_error_text(const DumpError& error) {
  std::string out;
  if (error.line != 0) out += fmt::format("line {}", error.line);
  if (error.line != 0 && error.column != 0) out += fmt::format(", column {}", error.column);
  if (error.line != 0) out += ": ";
  out += causes[static_cast<std::size_t>(error.cause)].text;
  if (error.expected != nullptr) out += fmt::format("; expected {}", error.expected);
  return out;
}

}  // namespace biss::dump
