#pragma once

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace biss::cli {

/// A file in memory without a name, read by its descriptor. Where the system has no memory for it, it
/// is empty, or ends early.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("biss", MFD_CLOEXEC)) {}
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return descriptor_; }
  /// What opens it is at its beginning.
  std::string path() const { return fmt::format("/dev/fd/{}", descriptor_); }
  void append(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::write(descriptor_, text.data(), text.size());
      if (count <= 0) return;
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  std::string text() const {
    std::string all;
    std::array<char, 65536> block{};
    for (off_t at = 0;;) {
      const ssize_t count = ::pread(descriptor_, block.data(), block.size(), at);
      if (count <= 0) return all;
      all.append(block.data(), static_cast<std::size_t>(count));
      at += count;
    }
  }

 private:
  int descriptor_;
};

}  // namespace biss::cli
