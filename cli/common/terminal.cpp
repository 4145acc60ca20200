#include "cli/common/terminal.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <string>

#include "cli/common/message.hpp"
#include "report/text.hpp"

namespace biss::cli {
namespace {

constexpr auto first_after = std::chrono::seconds(1);
constexpr auto then_every = std::chrono::milliseconds(200);

std::atomic<bool> line_shown = false;

void write_stderr(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::size_t terminal_columns(int descriptor) {
  if (descriptor < 0 || ::isatty(descriptor) != 1) return 0;
  winsize size{};
  return ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

Progress::Progress()
    : next_(std::chrono::steady_clock::now() + first_after),
      wanted_(!KeptMessages::in_use() && ::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (wanted_) clear_progress();
}

bool Progress::due() {
  if (!wanted_) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return false;
  next_ = now + then_every;
  return true;
}

void Progress::show(std::string_view text) {
  std::string printable;
  report::append_printable(printable, text);
  // A line that wraps cannot be replaced.
  const std::size_t columns = terminal_columns(STDERR_FILENO);
  while (columns != 0 && report::display_width(printable) >= columns) printable.pop_back();
  write_stderr("\r" + printable + "\x1b[K");
  line_shown = true;
}

void clear_progress() {
  if (line_shown.exchange(false)) write_stderr("\r\x1b[K");
}

}  // namespace biss::cli
