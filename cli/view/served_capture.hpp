// The capture that `biss view` gives to its page: a file that may grow, and must not change otherwise.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "verbs/common/host.hpp"

namespace biss::cli {

/// Bytes of a file from its beginning to a size that only grows. The size ends with a whole line or
/// sample, so that no number is read that is still being written.
class ServedCapture {
 public:
  ServedCapture() = default;
  ~ServedCapture();
  ServedCapture(const ServedCapture&) = delete;
  ServedCapture& operator=(const ServedCapture&) = delete;

  /// Opens a regular file, once. The error is ExitStatus::io: the file cannot be opened, is not
  /// a regular file, or has an error of look().
  /// \param follow serve also what is written later; otherwise only the present content
  /// \param sample_bytes bytes of a raw sample; without it the file is followed by lines
  tl::expected<void, verbs::VerbError> open(const std::string& path, bool follow,
                                            std::optional<std::uint64_t> sample_bytes);

  /// The size now. The error is one line of text for the user: the file has shrunk, was replaced or
  /// rewritten, or is of a kind that cannot be read while it grows. All later calls have it too.
  /// \param closely compare the whole served part if the file has changed; otherwise only its ends
  tl::expected<std::uint64_t, std::string> look(bool closely);

  /// The bytes at `offset`; fewer if the file ends before or reading fails.
  std::string text_at(std::uint64_t offset, std::size_t size) const;

 private:
  // These return one line of text for the user if the file can no longer be served, else nothing.
  std::string wrong_identity(const struct stat& opened) const;
  std::string wrong_content(const struct stat& opened, bool closely);
  std::string wrong_kind() const;
  std::string wrong_lines(std::uint64_t available);
  // The line of text for this reason.
  std::string refuse_to_follow(std::string_view why) const;
  std::uint64_t whole_size(std::uint64_t available) const;
  std::uint32_t checksum(std::uint32_t before, std::uint64_t begin, std::uint64_t end) const;
  // Serves the file up to `size`.
  void extend_to(std::uint64_t size);

  std::string path_;
  int descriptor_ = -1;
  bool follow_ = false;
  std::optional<std::uint64_t> sample_bytes_;
  std::uint64_t size_ = 0;
  // The bytes at the beginning and before the end of the served part.
  std::string head_;
  std::string tail_;
  // CRC-32 of the served part, and the time of the file's last change at the last comparison.
  std::uint32_t checksum_ = 0;
  timespec compared_{};
  // The size of a file without a line feed, at the last close look.
  std::uint64_t unfinished_ = 0;
  // The error of look(); empty if there is none.
  std::string problem_;
};

}  // namespace biss::cli
