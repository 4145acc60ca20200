#include "cli/live/record.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>

namespace biss::cli {

Record::Record(const std::string& path, verbs::Host& host) : path_(path), host_(host) {
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0) throw verbs::wrong_file("{}: {}", path, std::strerror(errno));
  held_ = "# biss read --record: the time and the bytes of each transfer, the first clock first\n";
}

Record::~Record() { ::close(descriptor_); }

void Record::add(Picoseconds time, std::span<const std::uint8_t> bytes) {
  if (ended_) {
    ++lost_;
    return;
  }
  // The clock has whole nanoseconds.
  fmt::format_to(std::back_inserter(held_), "{}ns ", time.count / 1'000);
  constexpr std::string_view digits = "0123456789ABCDEF";
  for (const std::uint8_t byte : bytes) {
    held_ += digits[byte >> 4U];
    held_ += digits[byte & 15U];
  }
  held_ += '\n';
  const auto now = std::chrono::steady_clock::now();
  if (now - written_ < std::chrono::milliseconds(100) && held_.size() < 65536) return;
  written_ = now;
  write();
}

void Record::comment(std::string_view text) {
  if (ended_) return;
  fmt::format_to(std::back_inserter(held_), "# {}\n", text);
  write();
}

void Record::write() {
  std::size_t done = 0;
  while (done < held_.size()) {
    const auto written = ::write(descriptor_, held_.data() + done, held_.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return end(done);
    done += static_cast<std::size_t>(written);
  }
  size_ += done;
  held_.clear();
}

// Only whole lines stay.
void Record::end(std::size_t done) {
  host_.warn(
      fmt::format("{}: {}; the record ends here, reading goes on", path_, std::strerror(errno)));
  const std::size_t whole = held_.rfind('\n', done == 0 ? 0 : done - 1);
  const std::size_t kept = done == 0 || whole == std::string::npos ? 0 : whole + 1;
  static_cast<void>(::ftruncate(descriptor_, static_cast<off_t>(size_ + kept)) == 0);
  // Comments are not transfers.
  const auto lost = held_.begin() + static_cast<std::ptrdiff_t>(kept);
  lost_ = static_cast<std::uint64_t>(std::count(lost, held_.end(), '\n') -
                                     std::count(lost, held_.end(), '#'));
  held_.clear();
  ended_ = true;
}

bool Record::finish() {
  write();
  if (!ended_) return true;
  host_.warn(fmt::format("{}: {} transfers are missing in the record", path_, lost_));
  return false;
}

}  // namespace biss::cli
