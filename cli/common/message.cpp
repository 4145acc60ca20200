#include "cli/common/message.hpp"

#include <cstdio>
#include <string>

#include "cli/common/terminal.hpp"
#include "report/text.hpp"

namespace biss::cli {

namespace {

thread_local KeptMessages* kept = nullptr;

}  // namespace

KeptMessages::KeptMessages() : outer_(kept) { kept = this; }
KeptMessages::~KeptMessages() { kept = outer_; }
bool KeptMessages::in_use() { return kept != nullptr; }

void warn(std::string_view text) {
  std::string line = "biss: ";
  report::append_printable(line, text);
  line.push_back('\n');
  if (kept == nullptr) return print_summary(line);
  kept->lines_.emplace_back(text);
  kept->text_ += line;
}

ExitStatus fail(ExitStatus status, std::string_view text) {
  warn(text);
  return status;
}

ExitStatus fail(const VerbError& error) { return fail(error.status, error.text); }

// A closed stderr cannot be reported.
void print_summary(std::string_view text) {
  std::string printable;
  report::append_printable_lines(printable, text);
  if (kept != nullptr) {
    kept->summary_ += printable;
    kept->text_ += printable;
    return;
  }
  clear_progress();
  std::fwrite(printable.data(), 1, printable.size(), stderr);
  std::fflush(stderr);
}

}  // namespace biss::cli
