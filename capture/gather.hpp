// Bytes that are kept in memory, or in a temporary file if they are many: until they can be used, or
// to be read at any place, for formats whose directory is at the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
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

/// Data that decompresses to more than this is not gathered.
inline constexpr std::uint64_t most_gathered_bytes = std::uint64_t{4} << 30U;

/// All bytes of a source. A regular file is read directly; anything else goes into memory first, or
/// beyond 16 MiB into a temporary file without a name. Fails as the source fails, and with
/// `read_failed` when there is no room for a temporary file.
tl::expected<Gathered, CaptureError> gather(std::unique_ptr<ByteSource> bytes);

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

/// The bytes from `place` to the end, front to back; `bytes` must outlive them.
std::unique_ptr<ByteSource> bytes_from(const PlacedBytes& bytes, std::uint64_t place);

}  // namespace biss::capture
