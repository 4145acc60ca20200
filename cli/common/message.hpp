// Messages on stderr: single lines.
#pragma once

#include <string>
#include <string_view>

#include "cli/common/exit_status.hpp"

namespace biss::cli {

/// Prints `biss: text` as exactly one line on stderr; control characters are replaced, so that a
/// file name cannot make two lines of it.
void warn(std::string_view text);

/// warn(), then the status to return: `return fail(ExitStatus::io, "…");`
/// An error says what, where in the file, and what to do.
ExitStatus fail(ExitStatus status, std::string_view text);

/// Why a verb ends early: the exit status, and one line that says so.
struct VerbError {
  ExitStatus status = ExitStatus::usage;
  std::string text;
};
ExitStatus fail(const VerbError& error);

/// Prints text as it is on stderr: a summary block.
void print_summary(std::string_view text);

}  // namespace biss::cli
