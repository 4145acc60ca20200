#pragma once

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace biss::cli {

/// A file in memory without a name, read by its descriptor, which is negative where the system has no
/// file left. append() throws where it cannot do its work whole.
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
      if (count <= 0) throw std::runtime_error("cannot write a file in memory");
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }

 private:
  int descriptor_;
};

}  // namespace biss::cli
