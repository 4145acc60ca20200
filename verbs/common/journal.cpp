#include "verbs/common/journal.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

namespace biss::verbs {

void Journal::open(const std::string& path, JournalKind kind, const OnLine& on_line) {
  path_ = path;
  kind_ = std::move(kind);
  open_and_lock();
  read_lines(on_line);
  if (unused_ > used_.size()) {
    rewrite([this](Output& output) { return copy_used(output); });
  }
}

void Journal::append(std::string_view line) { write(std::string(line) + '\n'); }

void Journal::replace(std::string_view line) {
  rewrite([line](Output& output) { return output.write(line) && output.write("\n"); });
}

void Journal::open_and_lock() {
  struct stat opened {};
  struct stat named {};
  do {
    close();
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOCTTY, 0666);
    if (file_ < 0) fail_with(errno);
    // A file system without locks is used without them.
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      fail("another run is writing it; wait for its end, or give another output");
    }
    if (::fstat(file_, &opened) != 0) fail_with(errno);
    if (!S_ISREG(opened.st_mode)) fail("not a regular file");
    bytes_ = static_cast<std::uint64_t>(opened.st_size);
    // Again if the process that had the lock before has replaced the file.
  } while (::stat(path_.c_str(), &named) != 0 || named.st_ino != opened.st_ino ||
           named.st_dev != opened.st_dev);
}

void Journal::read_lines(const OnLine& on_line) {
  std::ifstream file(path_, std::ios::binary);
  std::string line;
  const auto next_whole_line = [&] { return std::getline(file, line) && !file.eof(); };
  const bool any = next_whole_line();
  if (!file.is_open() || file.bad()) fail_with(EIO);
  // A run that was killed may have left the beginning of a header.
  const bool begun = !any && kind_.begins.starts_with(line);
  if (!begun && !line.starts_with(kind_.begins)) {
    fail("not a journal of " + kind_.owner + "; give another output");
  }
  if (any && line != kind_.header && !kind_.refusal.empty()) fail(kind_.refusal);
  if (!any || line != kind_.header) return begin();
  std::uint64_t place = line.size() + 1;
  for (; next_whole_line(); place += line.size() + 1) {
    if (on_line(line)) {
      used_.push_back({place, line.size() + 1});
    } else {
      ++unused_;
    }
  }
  if (file.bad()) fail_with(EIO);
  // The piece of a line at the end is of a run that was killed.
  if (::ftruncate(file_, static_cast<off_t>(place)) != 0) fail_with(errno);
}

// An empty journal: its entries mean nothing here.
void Journal::begin() {
  if (::ftruncate(file_, 0) != 0) fail_with(errno);
  append(kind_.header);
}

void Journal::rewrite(const std::function<bool(Output&)>& write_lines) {
  Output output(host_);
  if (!output.open(path_) || !output.write(kind_.header + '\n') || !write_lines(output) ||
      !output.finish()) {
    throw VerbError{ExitStatus::io, output.error()};
  }
  open_and_lock();
}

bool Journal::copy_used(Output& output) const {
  std::string line;
  for (const Line& used : used_) {
    line.resize(used.bytes);
    const ssize_t got = ::pread(file_, line.data(), line.size(), static_cast<off_t>(used.begin));
    if (got != static_cast<ssize_t>(line.size())) fail_with(got < 0 ? errno : EIO);
    if (!output.write(line)) return false;
  }
  return true;
}

void Journal::write(std::string_view text) {
  bytes_ += text.size();
  while (!text.empty()) {
    const ssize_t taken = ::write(file_, text.data(), text.size());
    if (taken < 0 && errno == EINTR) continue;
    if (taken < 0) fail_with(errno);
    text.remove_prefix(static_cast<std::size_t>(taken));
  }
}

void Journal::fail(const std::string& why) const { throw wrong_file("{}: {}", path_, why); }

void Journal::fail_with(int cause) const { fail(std::generic_category().message(cause)); }

void Journal::close() {
  if (file_ >= 0) ::close(std::exchange(file_, -1));
}

}  // namespace biss::verbs
