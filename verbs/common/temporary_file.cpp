#include "verbs/common/temporary_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

namespace biss::verbs {
namespace {

// Plain memory that a signal handler may read at any moment: a path is complete before `used` is
// set and does not change until it is cleared.
struct Entry {
  std::atomic<bool> used{false};
  std::array<char, PATH_MAX> path{};
};
static_assert(std::atomic<bool>::is_always_lock_free);

constinit std::array<Entry, 8> entries;

// Makes the signals remove this path from now on. False and errno if that is not possible.
bool remember(const std::string& path) {
  for (Entry& entry : entries) {
    if (entry.used) continue;
    if (path.size() >= entry.path.size()) {
      errno = ENAMETOOLONG;
      return false;
    }
    std::memcpy(entry.path.data(), path.c_str(), path.size() + 1);
    entry.used = true;
    return true;
  }
  errno = EMFILE;
  return false;
}

void forget(const std::string& path) {
  for (Entry& entry : entries) {
    if (entry.used && path == entry.path.data()) entry.used = false;
  }
}

extern "C" void remove_all_and_end(int signal_number) {
  for (const Entry& entry : entries) {
    if (entry.used) ::unlink(entry.path.data());
  }
  std::signal(signal_number, SIG_DFL);
  std::raise(signal_number);
}

std::string folder_of(const std::string& target) {
  const std::string folder = std::filesystem::path(target).parent_path().string();
  return folder.empty() ? "." : folder;
}

std::string descriptor_path(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

// Makes the file by make(name) in the target's folder, under a name that is not in use. The name is
// short: the target's may already be as long as names can be. Empty and errno on failure.
template <class Make>
std::string make_beside(const std::string& target, Make make) {
  constexpr int most_tries = 1000;
  for (int i = 0; i < most_tries; ++i) {
    std::string name = fmt::format("{}/.biss-{}-{}.tmp", folder_of(target), ::getpid(), i);
    if (!remember(name)) return {};
    if (make(name)) return name;
    forget(name);
    if (errno != EEXIST) return {};
  }
  return {};
}

}  // namespace

int TemporaryFile::create(const std::string& target) {
  target_ = target;
  descriptor_ = ::open(folder_of(target).c_str(), O_RDWR | O_TMPFILE | O_CLOEXEC, 0666);
  if (descriptor_ >= 0) {
    // Without /proc it could not be given a name.
    if (::access(descriptor_path(descriptor_).c_str(), F_OK) == 0) return descriptor_;
    ::close(std::exchange(descriptor_, -1));
  }
  name_ = make_beside(target_, [this](const std::string& name) {
    descriptor_ = ::open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    return descriptor_ >= 0;
  });
  return descriptor_;
}

bool TemporaryFile::take_name() {
  // Each close flushes: the last chance of a network file system to report that it is full.
  const int copy = ::fcntl(descriptor_, F_DUPFD_CLOEXEC, 0);
  if (copy < 0 || ::close(copy) != 0) return false;
  if (name_.empty()) {
    const auto link_to = [this](const std::string& name) {
      return ::linkat(AT_FDCWD, descriptor_path(descriptor_).c_str(), AT_FDCWD, name.c_str(),
                      AT_SYMLINK_FOLLOW) == 0;
    };
    if (link_to(target_)) {
      ::close(std::exchange(descriptor_, -1));
      return true;
    }
    // No call replaces a file by a file without a name, so the new file gets a name for a moment.
    if (errno != EEXIST) return false;
    name_ = make_beside(target_, link_to);
  }
  if (name_.empty() || std::rename(name_.c_str(), target_.c_str()) != 0) return false;
  forget(std::exchange(name_, {}));
  ::close(std::exchange(descriptor_, -1));
  return true;
}

void TemporaryFile::discard() {
  if (!name_.empty()) {
    ::unlink(name_.c_str());
    forget(std::exchange(name_, {}));
  }
  if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

void install_signal_handling() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(number, remove_all_and_end) == SIG_IGN) std::signal(number, SIG_IGN);
  }
}

}  // namespace biss::verbs
