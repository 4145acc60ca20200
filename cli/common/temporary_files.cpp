#include "cli/common/temporary_files.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>

namespace biss::cli {
namespace {

// Plain memory that a signal handler may read at any moment: a path is complete before `used` is
// set and is not touched before it is cleared.
struct Entry {
  std::atomic<bool> used{false};
  std::array<char, PATH_MAX> path{};
};
static_assert(std::atomic<bool>::is_always_lock_free);

constinit std::array<Entry, 8> entries;

Entry* find(const std::string& path) {
  for (Entry& entry : entries) {
    if (entry.used && path == entry.path.data()) return &entry;
  }
  return nullptr;
}

Entry* free_entry() {
  for (Entry& entry : entries) {
    if (!entry.used) return &entry;
  }
  return nullptr;
}

void forget(const std::string& path) {
  if (Entry* entry = find(path); entry != nullptr) entry->used = false;
}

extern "C" void remove_all_and_end(int signal_number) {
  for (const Entry& entry : entries) {
    if (entry.used) ::unlink(entry.path.data());
  }
  std::signal(signal_number, SIG_DFL);
  std::raise(signal_number);
}

}  // namespace

int create_temporary(const std::string& path) {
  Entry* entry = free_entry();
  if (entry == nullptr || path.size() >= entry->path.size()) {
    errno = entry == nullptr ? EMFILE : ENAMETOOLONG;
    return -1;
  }
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return -1;
  std::memcpy(entry->path.data(), path.c_str(), path.size() + 1);
  entry->used = true;
  return descriptor;
}

bool rename_temporary(const std::string& path, const std::string& target) {
  if (std::rename(path.c_str(), target.c_str()) != 0) return false;
  forget(path);
  return true;
}

void remove_temporary(const std::string& path) {
  ::unlink(path.c_str());
  forget(path);
}

void install_signal_handling() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
    if (std::signal(number, remove_all_and_end) == SIG_IGN) std::signal(number, SIG_IGN);
  }
}

}  // namespace biss::cli
