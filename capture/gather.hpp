// Bytes that can be read at any place, for formats whose directory is at the end.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "capture/bytes.hpp"
#include "capture/spool.hpp"

namespace biss::capture {

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
