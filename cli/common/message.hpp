// Messages on stderr: single lines.
#pragma once

#include <string>
#include <string_view>
#include <vector>

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

/// While it exists, this thread prints no message, summary or progress; they are kept here. For work
/// on captures of which many are read at a time, and for programs that are not the command.
class KeptMessages {
 public:
  KeptMessages();
  ~KeptMessages();
  KeptMessages(const KeptMessages&) = delete;
  KeptMessages& operator=(const KeptMessages&) = delete;

  /// In the order in which they came, without `biss:`.
  const std::vector<std::string>& lines() const { return lines_; }
  /// The summaries, one after the other.
  const std::string& summary() const { return summary_; }
  /// All of it, as the command prints it on stderr.
  const std::string& text() const { return text_; }
  /// This thread has one.
  static bool in_use();

 private:
  friend void warn(std::string_view text);
  friend void print_summary(std::string_view text);

  std::vector<std::string> lines_;
  std::string summary_;
  std::string text_;
  KeptMessages* outer_;
};

/// Prints text of several lines on stderr: a summary block. Control characters are replaced.
void print_summary(std::string_view text);

}  // namespace biss::cli
