// The header of a gzip member, RFC 1952, byte by byte.
#pragma once

#include <cstdint>

namespace biss::wasm {

class GzipHeader {
 public:
  enum class State : std::uint8_t { more, complete, wrong };

  /// Takes the next byte. \pre no call has returned anything but `more`
  State take(std::uint8_t byte);

 private:
  enum class Part : std::uint8_t { fixed, extra_size, extra, name, comment, checksum };

  State end_part(Part part);

  Part part_ = Part::fixed;
  std::uint8_t flags_ = 0;
  unsigned at_ = 0;
  unsigned value_ = 0;
  std::uint32_t checksum_ = 0;
};

}  // namespace biss::wasm
