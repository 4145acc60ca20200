// The journal of an archive: the entry of each file that was read, as soon as it was read.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "archive/entry.hpp"
#include "archive/summary.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"

namespace biss::verbs {

/// A file of lines that only grows, so that a run that is killed at any time loses the line at its
/// end at most. One process at a time.
class Journal {
 public:
  /// True: the entry is used. Any other entry is no longer of use.
  using OnEntry = std::function<bool(archive::StampedEntry entry)>;

  explicit Journal(Host& host) : host_(host) {}
  ~Journal() { close(); }
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  /// Opens or makes the file and reads its content. Entries under another header are dropped, and
  /// if most lines are useless, the file is written again. Prints why it cannot: another process
  /// has it open, the file is not a journal, it cannot be written.
  ExitStatus open(const std::string& path, const std::string& header, const OnEntry& on_entry) {
    path_ = path;
    ExitStatus status = open_and_lock(path);
    if (status == ExitStatus::done) status = read_lines(header, on_entry);
    if (status == ExitStatus::done && unused_ > used_.size()) status = rewrite(header);
    return status;
  }

  /// Adds an entry. Prints why it cannot.
  ExitStatus append(const archive::StampedEntry& entry) {
    return write(archive::journal_line(entry) + '\n');
  }

 private:
  struct Line {
    std::uint64_t begin = 0;
    std::uint64_t bytes = 0;
  };

  ExitStatus open_and_lock(const std::string& path) {
    for (;;) {
      close();
      file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOCTTY, 0666);
      if (file_ < 0) return fail_with(errno);
      // A file system without locks is used without them.
      if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        return host_.fail(
            ExitStatus::io,
            fmt::format("{}: another run is writing it; wait for its end, or give another "
                        "output",
                        path));
      }
      struct stat opened {};
      struct stat named {};
      if (::fstat(file_, &opened) != 0) return fail_with(errno);
      if (!S_ISREG(opened.st_mode)) {
        return host_.fail(ExitStatus::io, fmt::format("{}: not a regular file", path));
      }
      // The one who had the lock before may have replaced the file.
      if (::stat(path.c_str(), &named) == 0 && named.st_ino == opened.st_ino &&
          named.st_dev == opened.st_dev) {
        return ExitStatus::done;
      }
    }
  }

  ExitStatus read_lines(const std::string& header, const OnEntry& on_entry) {
    std::ifstream file(path_, std::ios::binary);
    std::string line;
    const auto next_whole_line = [&] { return std::getline(file, line) && !file.eof(); };
    const bool any = next_whole_line();
    if (!file.is_open() || file.bad()) return fail_with(EIO);
    // A run that was killed may have left the beginning of a header.
    const bool begun = !any && archive::own_files_begin.starts_with(line);
    if (!begun && !line.starts_with(archive::own_files_begin)) {
      return host_.fail(
          ExitStatus::io,
          fmt::format("{}: not a journal of biss archive; give another output", path_));
    }
    if (!any || line != header) return begin(header);
    std::uint64_t place = line.size() + 1;
    for (; next_whole_line(); place += line.size() + 1) {
      auto entry = archive::read_journal_line(line);
      if (entry && on_entry(std::move(*entry))) {
        used_.push_back({place, line.size() + 1});
      } else {
        ++unused_;
      }
    }
    if (file.bad()) return fail_with(EIO);
    // The piece of a line at the end is of a run that was killed.
    return ::ftruncate(file_, static_cast<off_t>(place)) == 0 ? ExitStatus::done : fail_with(errno);
  }

  // An empty journal: its entries mean nothing here.
  ExitStatus begin(const std::string& header) {
    if (::ftruncate(file_, 0) != 0) return fail_with(errno);
    return write(header + '\n');
  }

  ExitStatus rewrite(const std::string& header) {
    Output file(host_);
    if (!file.open(path_) || !file.write(header + '\n')) return file.status();
    std::string line;
    for (const Line& used : used_) {
      line.resize(used.bytes);
      const ssize_t got = ::pread(file_, line.data(), line.size(), static_cast<off_t>(used.begin));
      if (got != static_cast<ssize_t>(line.size())) return fail_with(got < 0 ? errno : EIO);
      if (!file.write(line)) return file.status();
    }
    if (!file.finish()) return file.status();
    return open_and_lock(path_);
  }

  ExitStatus write(std::string_view text) {
    while (!text.empty()) {
      const ssize_t taken = ::write(file_, text.data(), text.size());
      if (taken < 0 && errno == EINTR) continue;
      if (taken < 0) return fail_with(errno);
      text.remove_prefix(static_cast<std::size_t>(taken));
    }
    return ExitStatus::done;
  }

  ExitStatus fail_with(int cause) const {
    return host_.fail(ExitStatus::io,
                      fmt::format("{}: {}", path_, std::generic_category().message(cause)));
  }

  void close() {
    if (file_ >= 0) ::close(std::exchange(file_, -1));
  }

  Host& host_;
  std::string path_;
  int file_ = -1;
  std::vector<Line> used_;
  std::uint64_t unused_ = 0;
};

}  // namespace biss::verbs
