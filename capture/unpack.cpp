#include "capture/unpack.hpp"

#include <lz4.h>

#include <algorithm>
#include <cstddef>
#include <limits>

namespace biss::capture {
namespace {

bool unpack_lz4(std::span<const std::uint8_t> packed, std::span<std::uint8_t> into) {
  constexpr std::size_t most = std::numeric_limits<int>::max();
  if (packed.size() > most || into.size() > most) return false;
  const int made = LZ4_decompress_safe(
      reinterpret_cast<const char*>(packed.data()), reinterpret_cast<char*>(into.data()),
      static_cast<int>(packed.size()), static_cast<int>(into.size()));
  return made >= 0 && static_cast<std::size_t>(made) == into.size();
}

// A command is a byte: below 32 that many literals and one more; otherwise its upper three bits
// are a length, its lower five the upper bits of a distance. Level 2 has long lengths and distances.
class FastLz {
 public:
  FastLz(std::span<const std::uint8_t> packed, std::span<std::uint8_t> into)
      : packed_(packed), into_(into) {}

  bool unpack() {
    if (packed_.empty()) return into_.empty();
    const unsigned level = packed_[0] >> 5U;
    if (level > 1) return false;
    long_matches_ = level == 1;
    unsigned command = packed_[at_++] & 31U;
    for (;;) {
      if (!(command < 32 ? copy_literals(command + 1) : copy_match(command))) return false;
      if (at_ == packed_.size()) return made_ == into_.size();
      command = packed_[at_++];
    }
  }

 private:
  static constexpr std::size_t last_short_distance = 8'191;

  bool next(std::size_t& byte) {
    if (at_ == packed_.size()) return false;
    byte = packed_[at_++];
    return true;
  }

  bool copy_literals(std::size_t count) {
    if (count > packed_.size() - at_ || count > into_.size() - made_) return false;
    std::copy_n(packed_.begin() + static_cast<std::ptrdiff_t>(at_), count,
                into_.begin() + static_cast<std::ptrdiff_t>(made_));
    at_ += count;
    made_ += count;
    return true;
  }

  bool copy_match(unsigned command) {
    std::size_t count = (command >> 5U) + 2U;
    std::size_t distance = std::size_t{command & 31U} << 8U;
    std::size_t more = 255;
    while (count >= 9 && more == 255) {
      if (!next(more)) return false;
      count += more;
      if (!long_matches_) break;
    }
    std::size_t low = 0;
    if (!next(low)) return false;
    const bool far = long_matches_ && low == 255 && distance == 31U << 8U;
    distance += low;
    if (far) {
      std::size_t high = 0;
      if (!next(high) || !next(low)) return false;
      distance = (high << 8U | low) + last_short_distance;
    }
    ++distance;
    if (distance > made_ || count > into_.size() - made_) return false;
    // Byte by byte: a match may overlap its own output.
    for (; count != 0; --count, ++made_) into_[made_] = into_[made_ - distance];
    return true;
  }

  std::span<const std::uint8_t> packed_;
  std::span<std::uint8_t> into_;
  std::size_t at_ = 0;
  std::size_t made_ = 0;
  bool long_matches_ = false;
};

}  // namespace

bool unpack(Packing packing, std::span<const std::uint8_t> packed, std::span<std::uint8_t> into,
            Inflater& inflater) {
  switch (packing) {
    case Packing::zlib:
      return inflater.inflate(packed, into, DeflateFrame::zlib);
    case Packing::gzip:
      return inflater.inflate(packed, into, DeflateFrame::gzip);
    case Packing::lz4:
      return unpack_lz4(packed, into);
    case Packing::fastlz:
      return FastLz(packed, into).unpack();
  }
  return false;
}

}  // namespace biss::capture
