// Memory that is used again and again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace biss::capture {

/// Bytes that are not filled with zeros first.
class Buffer {
 public:
  /// `bytes` bytes of any content, valid until the next call.
  std::span<std::uint8_t> take(std::size_t bytes) {
    if (bytes > capacity_) {
      bytes_ = std::make_unique_for_overwrite<std::uint8_t[]>(bytes);
      capacity_ = bytes;
    }
    return {bytes_.get(), bytes};
  }

 private:
  std::unique_ptr<std::uint8_t[]> bytes_;
  std::size_t capacity_ = 0;
};

}  // namespace biss::capture
