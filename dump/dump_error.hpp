// Why a dump cannot be read: one enumerator a cause, and the place.
#pragma once

#include <cstdint>
#include <string>

namespace biss::dump {

enum class DumpCause : std::uint8_t {
  cannot_open,      ///< missing, no permission
  is_directory,     ///< the path names a folder
  read_failed,      ///< the system refused to read on
  empty,            ///< no byte, or nothing but white space and comments
  unknown_format,   ///< text of no shape that is known
  malformed,        ///< a line that the format does not allow
  line_too_long,    ///< a line longer than any valid one
  not_whole_banks,  ///< binary whose size is no multiple of 64
  outside,          ///< an address or offset where there is no register
  checksum,         ///< a record of Intel HEX whose bytes do not add up to 0
  contradiction,    ///< a byte given twice, with two values
  several_slaves,   ///< accesses to more than one slave, and none was named
  nothing_read,     ///< no access that brought a byte (of the slave named)
  truncated,        ///< the file ends before it says that it does
};

/// `line` and `column` count from 1, columns in bytes; 0 where they have no meaning. `expected`
/// says what would have been right there: static text, or null.
struct DumpError {
  DumpCause cause{};
  std::uint64_t line = 0;
  std::uint64_t column = 0;
  const char* expected = nullptr;
};

/// The name of a cause, the same as the enumerator's.
const char* name_of(DumpCause cause);

/// One line for a user: "line 3, column 7: expected two hexadecimal digits".
std::string dump_error_text(const DumpError& error);

}  // namespace biss::dump
