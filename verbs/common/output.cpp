#include "verbs/common/output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "report/text.hpp"
#include "verbs/common/files.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::verbs {
namespace {

constexpr std::size_t block_bytes = 64U * 1024U;

std::string reason(int cause) { return std::generic_category().message(cause); }

}  // namespace

std::size_t output_columns(Host& host) {
  return host.output() == nullptr ? terminal_columns(STDOUT_FILENO) : 0;
}

Output::~Output() { abandon(); }

bool Output::open(const std::string& path) {
  if (path.empty() || path == "-") {
    name_ = "stdout";
    text_ = host_.output();
    descriptor_ = STDOUT_FILENO;
    is_terminal_ = text_ == nullptr && ::isatty(descriptor_) == 1;
    return true;
  }
  name_ = "'" + path + "'";
  const std::string target = follow_links(path);
  if (target.empty()) return fail("cannot open", ELOOP);
  struct stat about {};
  const bool exists = ::stat(target.c_str(), &about) == 0;
  if (!exists && errno != ENOENT) return fail("cannot open", errno);
  if (exists && S_ISDIR(about.st_mode)) return fail("cannot write", EISDIR);
  if (exists && ::access(target.c_str(), W_OK) != 0) return fail("cannot write", errno);
  if ((!exists || S_ISREG(about.st_mode)) && !names_a_descriptor(target)) {
    descriptor_ = temporary_.create(target);
    if (descriptor_ < 0) return fail("cannot create a file next to", errno);
    // A file that was made private stays private.
    if (exists && ::fchmod(descriptor_, about.st_mode & 07777U) != 0) {
      return fail("cannot set the mode of", errno);
    }
    return true;
  }
  descriptor_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_APPEND);
  owns_descriptor_ = true;
  is_terminal_ = ::isatty(descriptor_) == 1;
  return descriptor_ >= 0 || fail("cannot open", errno);
}

bool Output::write(std::string_view text) {
  if (reader_left_) return true;
  if (descriptor_ < 0) return false;
  if (text_ != nullptr) {
    text_->append(text);
    return true;
  }
  if (held_.size() + text.size() < block_bytes) {
    held_.append(text);
    return !soon_ || write_held();
  }
  // In one piece, so that a character that two writes share stays whole on a terminal.
  if (is_terminal_) held_.append(std::exchange(text, {}));
  const bool good = write_through(held_) && write_through(text);
  held_.clear();
  return good;
}

bool Output::write_held() {
  const auto now = std::chrono::steady_clock::now();
  if (now - written_ < std::chrono::milliseconds(100)) return true;
  written_ = now;
  return write_through(std::exchange(held_, {}));
}

bool Output::write_printable(std::string_view text) {
  if (!is_terminal_ || reader_left_ || descriptor_ < 0) return write(text);
  return write_through(std::exchange(held_, {})) && write_bytes(text);
}

bool Output::write_through(std::string_view text) {
  if (!is_terminal_) return write_bytes(text);
  std::string printable;
  report::append_printable_lines(printable, text);
  return write_bytes(printable);
}

bool Output::write_bytes(std::string_view text) {
  clear_progress();
  while (!text.empty() && !reader_left_) {
    const ssize_t taken = ::write(descriptor_, text.data(), text.size());
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0 && errno == EPIPE) {
      reader_left_ = true;
    } else if (taken < 0) {
      return fail("cannot write", errno);
    } else {
      text.remove_prefix(static_cast<std::size_t>(taken));
    }
  }
  return true;
}

bool Output::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (descriptor_ >= 0 && !bytes.empty()) {
    const ssize_t taken =
        ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0) return fail("cannot write", errno);
    offset += static_cast<std::uint64_t>(taken);
    bytes = bytes.subspan(static_cast<std::size_t>(taken));
  }
  return descriptor_ >= 0;
}

bool Output::read_at(std::uint64_t offset, std::span<std::byte> bytes) {
  while (descriptor_ >= 0 && !bytes.empty()) {
    const ssize_t taken =
        ::pread(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0) return fail("cannot read back", errno);
    if (taken == 0) break;
    offset += static_cast<std::uint64_t>(taken);
    bytes = bytes.subspan(static_cast<std::size_t>(taken));
  }
  std::fill(bytes.begin(), bytes.end(), std::byte{});
  return descriptor_ >= 0;
}

void Output::fail(std::string_view cause) {
  if (error_.empty()) error_ = fmt::format("cannot write {}: {}", name_, cause);
  close();
}

bool Output::finish() {
  if (descriptor_ < 0) return false;
  if (!write_through(held_)) return false;
  held_.clear();
  if (temporary_.exists()) {
    if (!temporary_.take_name()) return fail("cannot replace", errno);
    descriptor_ = -1;
    return true;
  }
  const int descriptor = std::exchange(descriptor_, -1);
  return !owns_descriptor_ || ::close(descriptor) == 0 || fail("cannot write", errno);
}

void Output::abandon() {
  if (descriptor_ >= 0 && !temporary_.exists()) write_through(held_);
  close();
}

bool Output::fail(std::string_view what, int cause) {
  error_ = fmt::format("{} {}: {}", what, name_, reason(cause));
  close();
  return false;
}

void Output::close() {
  held_.clear();
  if (owns_descriptor_ && descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  temporary_.discard();
}

ExitStatus Output::status() const {
  return error_.empty() ? ExitStatus::done : host_.fail(ExitStatus::io, error_);
}

report::TableOptions Output::table_options() const {
  if (descriptor_ < 0 || !is_terminal_) return {};
  const char* no_colour = std::getenv("NO_COLOR");
  const char* terminal = std::getenv("TERM");
  report::TableOptions options;
  options.colour = (no_colour == nullptr || *no_colour == '\0') && terminal != nullptr &&
                   std::string_view(terminal) != "dumb";
  options.width = terminal_columns(descriptor_);
  options.on_left_out = [&host = host_](const std::vector<std::string>& columns) {
    host.warn(fmt::format("the terminal is too narrow for {}; widen it, or use --to csv",
                          fmt::join(columns, ", ")));
  };
  return options;
}

void prepare_process() {
  // The wrong direction on purpose: a use of the stream fails.
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) != -1) continue;
    const int mode = descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY;
    if (::open("/dev/null", mode) != descriptor) return;
  }
  install_signal_handling();
}

}  // namespace biss::verbs
