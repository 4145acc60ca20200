// Deflated data and checksums, a whole piece at a time. Each thread has its own Inflater.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

struct libdeflate_compressor;
struct libdeflate_decompressor;

namespace biss::capture {

/// A byte of deflated data makes no more bytes than this.
inline constexpr std::uint64_t max_deflate_ratio = 1'032;

class Inflater {
 public:
  Inflater();

  /// Whether `deflated` is whole and makes exactly `into.size()` bytes, which are then in `into`.
  bool inflate(std::span<const std::uint8_t> deflated, std::span<std::uint8_t> into);

 private:
  struct Free {
    void operator()(libdeflate_decompressor* decompressor) const;
  };
  std::unique_ptr<libdeflate_decompressor, Free> decompressor_;
};

class Deflater {
 public:
  Deflater();

  /// Appends `bytes` deflated to `out`.
  void deflate(std::span<const std::uint8_t> bytes, std::string& out);

 private:
  struct Free {
    void operator()(libdeflate_compressor* compressor) const;
  };
  std::unique_ptr<libdeflate_compressor, Free> compressor_;
};

/// CRC-32 as ZIP has it.
std::uint32_t zip_checksum(std::span<const std::uint8_t> bytes);

}  // namespace biss::capture
