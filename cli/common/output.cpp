#include "cli/common/output.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <utility>

#include "cli/common/message.hpp"
#include "cli/common/temporary_files.hpp"

namespace biss::cli {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t block_bytes = 64U * 1024U;

std::string reason(int cause) { return std::generic_category().message(cause); }

// /dev/stdout and the like lead here: names of open descriptors, not of files to replace.
bool names_a_descriptor(const std::string& path) {
  return path.starts_with("/proc/") || path.starts_with("/dev/fd/");
}

// Follows symbolic links at the end of the path, also to a target that does not exist.
// Empty when they run in a circle.
std::string follow_links(std::string path) {
  constexpr int most_links = 40;
  for (int i = 0; i < most_links; ++i) {
    std::error_code failed;
    const fs::path next = fs::read_symlink(path, failed);
    if (failed || names_a_descriptor(path)) return path;
    path = next.is_absolute() ? next.string() : (fs::path(path).parent_path() / next).string();
  }
  return {};
}

}  // namespace

Output::~Output() { abandon(); }

bool Output::open(const std::string& path) {
  if (path.empty() || path == "-") {
    name_ = "stdout";
    descriptor_ = STDOUT_FILENO;
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
    if (!open_temporary(target)) return false;
    // A file that was made private stays so.
    if (exists && ::fchmod(descriptor_, about.st_mode & 07777U) != 0) {
      return fail("cannot set the mode of", errno);
    }
    return true;
  }
  descriptor_ = ::open(target.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY | O_APPEND);
  owns_descriptor_ = true;
  return descriptor_ >= 0 || fail("cannot open", errno);
}

bool Output::open_temporary(const std::string& target) {
  // A short name of its own: the target's may already be as long as names can be.
  const fs::path folder = fs::path(target).parent_path();
  constexpr int most_tries = 1000;
  for (int i = 0; i < most_tries; ++i) {
    const std::string name = (folder / fmt::format(".biss-{}-{}.tmp", ::getpid(), i)).string();
    descriptor_ = create_temporary(name);
    if (descriptor_ >= 0) {
      temporary_ = name;
      target_ = target;
      owns_descriptor_ = true;
      return true;
    }
    if (errno != EEXIST) break;
  }
  return fail("cannot create a file beside", errno);
}

bool Output::write(std::string_view text) {
  if (failed_ || descriptor_ < 0) return false;
  if (held_.size() + text.size() < block_bytes) {
    held_.append(text);
    return true;
  }
  const bool good = write_through(held_) && write_through(text);
  held_.clear();
  return good;
}

bool Output::write_through(std::string_view text) {
  while (!text.empty()) {
    const ssize_t taken = ::write(descriptor_, text.data(), text.size());
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0) return fail("cannot write", errno);
    text.remove_prefix(static_cast<std::size_t>(taken));
  }
  return true;
}

bool Output::finish() {
  if (failed_ || descriptor_ < 0) return false;
  if (!write_through(held_)) return false;
  held_.clear();
  const int descriptor = std::exchange(descriptor_, -1);
  // The last chance of a network file system to say that it is full.
  if (owns_descriptor_ && ::close(descriptor) != 0) return fail("cannot write", errno);
  if (temporary_.empty()) return true;
  if (!rename_temporary(temporary_, target_)) return fail("cannot replace", errno);
  temporary_.clear();
  return true;
}

void Output::abandon() {
  // A failure here comes after one that has been told already.
  if (!failed_ && descriptor_ >= 0 && temporary_.empty()) write_through(held_);
  held_.clear();
  discard();
}

bool Output::fail(std::string_view what, int cause) {
  failed_ = true;
  reader_left_ = cause == EPIPE;
  if (!reader_left_) error_ = fmt::format("{} {}: {}", what, name_, reason(cause));
  discard();
  return false;
}

void Output::discard() {
  if (owns_descriptor_ && descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) remove_temporary(temporary_);
  temporary_.clear();
}

ExitStatus Output::status() const {
  return error_.empty() ? ExitStatus::done : cli::fail(ExitStatus::io, error_);
}

bool Output::wants_colour() const {
  const char* no_colour = std::getenv("NO_COLOR");
  if (no_colour != nullptr && *no_colour != '\0') return false;
  const char* terminal = std::getenv("TERM");
  if (terminal == nullptr || std::string_view(terminal) == "dumb") return false;
  return descriptor_ >= 0 && ::isatty(descriptor_) == 1;
}

void prepare_process() {
  // The wrong direction on purpose: whoever uses the stream shall find the error.
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(descriptor, F_GETFD) != -1) continue;
    const int mode = descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY;
    if (::open("/dev/null", mode) != descriptor) return;
  }
  install_signal_handling();
}

}  // namespace biss::cli
