// Bytes that are kept until they can be used: in memory, or in a temporary file when there are
// many.
#pragma once

#include <cstddef>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "capture/bytes.hpp"

namespace biss::capture {

using Stdio = std::unique_ptr<std::FILE, Released<std::fclose>>;

/// A file without a name in TMPDIR, /tmp by default. Null on failure.
Stdio temporary_file();

/// Bytes in a stream, or in memory if `file` is null.
struct Gathered {
  Stdio file;
  std::string memory;
};

/// Appended first, then read once from the beginning. More than 16 MiB are in a temporary file.
class Spool {
 public:
  /// False when the temporary file cannot be written.
  bool append(std::string_view bytes);
  /// Ends appending. False when the temporary file cannot be written.
  bool rewind();
  /// Fills `into` with the next bytes and returns how many there were. \pre rewind() returned true
  std::size_t read(std::span<char> into);
  /// Gives the bytes away. \pre rewind() returned true
  Gathered take() { return std::move(bytes_); }

 private:
  bool spill();

  Gathered bytes_;
  std::size_t read_bytes_ = 0;
};

}  // namespace biss::capture
