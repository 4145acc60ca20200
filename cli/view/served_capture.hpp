// The capture that `biss view` gives to its page: a file that may grow, and must not change otherwise.
#pragma once

#include <sys/stat.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "cli/common/message.hpp"

namespace biss::cli {

/// What is known of a file that is still being written.
struct Growth {
  /// Bytes of a raw sample; without it the file is read by lines.
  std::optional<std::uint64_t> sample_bytes;
};

/// Bytes of a file from its beginning to a size that only grows. The size ends with a whole line or
/// sample, so that no number is read that is still being written.
class ServedCapture {
 public:
  ServedCapture() = default;
  ~ServedCapture();
  ServedCapture(const ServedCapture&) = delete;
  ServedCapture& operator=(const ServedCapture&) = delete;

  /// Opens a regular file. \param growth nothing: what it has now is all that is served
  tl::expected<void, VerbError> open(const std::string& path, std::optional<Growth> growth);

  /// The size now. The error is one line: the file has shrunk, was replaced or rewritten, or is of a
  /// kind that cannot be read while it grows. It stays.
  tl::expected<std::uint64_t, std::string> look();

  /// Reads at `offset`, at most to the size that look() gave last.
  /// \return how much; 0 where reading fails
  std::size_t read(std::uint64_t offset, std::span<char> bytes) const;

 private:
  std::string wrong_identity() const;
  std::string wrong_content() const;
  std::string wrong_kind() const;
  std::uint64_t whole_size(std::uint64_t available) const;
  std::string text_at(std::uint64_t offset, std::size_t size) const;
  void remember(std::uint64_t size);

  std::string path_;
  int descriptor_ = -1;
  std::optional<Growth> growth_;
  std::uint64_t size_ = 0;
  // The bytes at the beginning and before the end of what has been served.
  std::string head_;
  std::string tail_;
  std::string problem_;
};

}  // namespace biss::cli
