// Bytes that can be read at any place, for formats whose directory is at the end.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "capture/bytes.hpp"

namespace biss::capture {

struct CloseStdio {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using Stdio = std::unique_ptr<std::FILE, CloseStdio>;

/// All bytes of a source: a stream on a regular file, or where `file` is null, in memory.
struct Gathered {
  Stdio file;
  std::string memory;
};

/// A regular file is read where it lies; anything else goes into memory first, or beyond 16 MiB into
/// a temporary file without a name. Nothing when the source cannot be read.
std::optional<Gathered> gather(std::unique_ptr<ByteSource> bytes);

/// Gathered bytes by their place.
class PlacedBytes {
 public:
  PlacedBytes() = default;
  explicit PlacedBytes(Gathered bytes);

  std::uint64_t size() const { return size_; }
  /// Fills `into` from `place` on; false when the bytes are not there or cannot be read.
  bool read(std::uint64_t place, std::span<std::uint8_t> into) const;

 private:
  Gathered bytes_;
  std::uint64_t size_ = 0;
};

}  // namespace biss::capture
