#pragma once

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

#include "cli/common/output.hpp"

namespace biss::cli {

/// A file in memory without a name, read by its descriptor, which is negative where the system has no
/// file left. append() and text() throw where they cannot do their work whole.
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
  std::string text() const {
    std::string all;
    std::array<char, 65536> block{};
    for (off_t at = 0;;) {
      const ssize_t count = ::pread(descriptor_, block.data(), block.size(), at);
      if (count < 0) throw std::runtime_error("cannot read a file in memory");
      if (count == 0) return all;
      all.append(block.data(), static_cast<std::size_t>(count));
      at += count;
    }
  }

 private:
  int descriptor_;
};

/// What this thread writes to standard output while the object exists, in memory.
class CapturedOutput {
 public:
  CapturedOutput() : before_(set_standard_output(file_.descriptor())) {}
  ~CapturedOutput() { set_standard_output(before_); }
  CapturedOutput(const CapturedOutput&) = delete;
  CapturedOutput& operator=(const CapturedOutput&) = delete;

  const MemoryFile& file() const { return file_; }

 private:
  MemoryFile file_;
  int before_;
};

}  // namespace biss::cli
