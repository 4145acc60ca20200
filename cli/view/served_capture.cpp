#include "cli/view/served_capture.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <libdeflate.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "capture/text_source.hpp"

namespace biss::cli {

namespace {

// The part of a file that is compared to see that the file has only grown.
constexpr std::size_t compared_bytes = 4096;
constexpr std::size_t block_bytes = std::size_t{64} << 10U;
// A line is not longer.
constexpr std::uint64_t line_bytes_max = std::uint64_t{1} << 20U;

struct Whole {
  std::string_view magic;
  const char* why;
};

constexpr auto only_whole = std::to_array<Whole>({
    {"PK", "the directory of an archive (.sr, .sal, .dsl) is at its end"},
    {"\x1f\x8b", "a compressed file ends with its checksum"},
    {"\x28\xb5\x2f\xfd", "a compressed file ends with its checksum"},
    {"<SALEAE>", "a binary export of Saleae Logic begins with the number of its changes"},
    {"\x89HDF", "an HDF5 file is not written from its beginning to its end"},
});

}  // namespace

ServedCapture::~ServedCapture() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

tl::expected<void, verbs::VerbError> ServedCapture::open(
    const std::string& path, bool follow, std::optional<std::uint64_t> sample_bytes) {
  const auto refuse = [&](std::string_view why) {
    return tl::unexpected(
        verbs::VerbError{verbs::ExitStatus::io, fmt::format("{}: {}", path, why)});
  };
  path_ = path;
  follow_ = follow;
  sample_bytes_ = sample_bytes;
  // Without waiting for the writer of a pipe.
  descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) return refuse(std::strerror(errno));
  struct stat about {};
  if (::fstat(descriptor_, &about) != 0) return refuse(std::strerror(errno));
  if (!S_ISREG(about.st_mode))
    return refuse("is not a regular file: the page must be able to read parts of it again");
  unfinished_ = static_cast<std::uint64_t>(about.st_size);
  extend_to(whole_size(unfinished_));
  const auto size = look(true);
  if (!size) return tl::unexpected(verbs::VerbError{verbs::ExitStatus::io, size.error()});
  return {};
}

tl::expected<std::uint64_t, std::string> ServedCapture::look(bool closely) {
  struct stat about {};
  if (problem_.empty() && ::fstat(descriptor_, &about) != 0) {
    problem_ = fmt::format("{}: {}", path_, std::strerror(errno));
  }
  if (problem_.empty()) problem_ = wrong_identity(about);
  if (problem_.empty()) problem_ = wrong_content(about, closely);
  if (problem_.empty() && follow_) problem_ = wrong_kind();
  if (!problem_.empty()) return tl::unexpected(problem_);
  if (!follow_) return size_;
  const auto available = static_cast<std::uint64_t>(about.st_size);
  if (available > size_) extend_to(whole_size(available));
  if (closely && !sample_bytes_) problem_ = wrong_lines(available);
  if (!problem_.empty()) return tl::unexpected(problem_);
  return size_;
}

// The file of this name must be the open file, and must still begin with the served bytes.
std::string ServedCapture::wrong_identity(const struct stat& opened) const {
  struct stat named {};
  if (static_cast<std::uint64_t>(opened.st_size) < size_) {
    return fmt::format(
        "{}: has shrunk from {} to {} bytes while it was read; start biss view again", path_, size_,
        opened.st_size);
  }
  if (::stat(path_.c_str(), &named) != 0) {
    return fmt::format("{}: {}; it was there when biss view was started", path_,
                       std::strerror(errno));
  }
  if (named.st_dev != opened.st_dev || named.st_ino != opened.st_ino) {
    return fmt::format("{}: was replaced by another file while it was read; start biss view again",
                       path_);
  }
  return {};
}

std::string ServedCapture::wrong_content(const struct stat& opened, bool closely) {
  const bool same_ends =
      text_at(0, head_.size()) == head_ && text_at(size_ - tail_.size(), tail_.size()) == tail_;
  if (same_ends && !closely) return {};
  const timespec changed = opened.st_ctim;
  const bool unchanged = changed.tv_sec == compared_.tv_sec && changed.tv_nsec == compared_.tv_nsec;
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  if (!same_ends || (!unchanged && checksum(0, 0, size_) != checksum_)) {
    return fmt::format("{}: was rewritten while it was read; start biss view again", path_);
  }
  // A change just after this one may have the same time.
  if (now.tv_sec > changed.tv_sec + 1) compared_ = changed;
  return {};
}

std::string ServedCapture::refuse_to_follow(std::string_view why) const {
  return fmt::format("{}: cannot be followed while it grows: {}; leave out --follow", path_, why);
}

// A first line may be half written. If it does not grow from one look to the next, it is refused.
std::string ServedCapture::wrong_lines(std::uint64_t available) {
  if (available - std::min(available, size_) > line_bytes_max) {
    return refuse_to_follow("its last line has more than 1 MiB");
  }
  if (capture::has_cr_inside(text_at(size_, static_cast<std::size_t>(available - size_)))) {
    return refuse_to_follow("it has lines that end in CR alone");
  }
  const bool rests =
      size_ == 0 && available != 0 && available == std::exchange(unfinished_, available);
  return rests ? refuse_to_follow("it has no line feed yet") : "";
}

std::string ServedCapture::wrong_kind() const {
  if (sample_bytes_) return {};
  const std::string head = text_at(0, compared_bytes);
  const auto refuse = [&](std::string_view why) { return refuse_to_follow(why); };
  for (const auto& [magic, why] : only_whole) {
    if (head.starts_with(magic)) return refuse(why);
  }
  const bool is_text = std::none_of(head.begin(), head.end(), [](char c) {
    return (c >= 0 && c < ' ' && c != '\t' && c != '\n' && c != '\r') || c == '\x7f';
  });
  if (!is_text) {
    return refuse("it is not text (VCD, CSV), and raw samples need --raw-rate");
  }
  return {};
}

// The part of the file that can be read: complete samples or lines.
std::uint64_t ServedCapture::whole_size(std::uint64_t available) const {
  if (!follow_) return available;
  if (sample_bytes_) return available - available % *sample_bytes_;
  const std::uint64_t least = std::max(size_, available - std::min(available, line_bytes_max));
  for (std::uint64_t end = available; end > least;) {
    const std::uint64_t begin = end - std::min<std::uint64_t>(end - least, block_bytes);
    const std::string block = text_at(begin, static_cast<std::size_t>(end - begin));
    const std::size_t feed = block.rfind('\n');
    if (feed != std::string::npos) return begin + feed + 1;
    end = begin;
  }
  return size_;
}

void ServedCapture::extend_to(std::uint64_t size) {
  checksum_ = checksum(checksum_, size_, size);
  size_ = size;
  const auto compared = static_cast<std::size_t>(std::min<std::uint64_t>(size, compared_bytes));
  head_ = text_at(0, compared);
  tail_ = text_at(size - compared, compared);
}

// CRC-32 of these bytes, continued from `before`.
std::uint32_t ServedCapture::checksum(std::uint32_t before, std::uint64_t begin,
                                      std::uint64_t end) const {
  while (begin < end) {
    const std::string block =
        text_at(begin, static_cast<std::size_t>(std::min<std::uint64_t>(end - begin, 1U << 20U)));
    if (block.empty()) break;
    before = ::libdeflate_crc32(before, block.data(), block.size());
    begin += block.size();
  }
  return before;
}

std::string ServedCapture::text_at(std::uint64_t offset, std::size_t size) const {
  std::string text(size, '\0');
  std::size_t got = 0;
  while (got < size) {
    const ssize_t more =
        ::pread(descriptor_, text.data() + got, size - got, static_cast<off_t>(offset + got));
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) break;
    got += static_cast<std::size_t>(more);
  }
  text.resize(got);
  return text;
}

}  // namespace biss::cli
