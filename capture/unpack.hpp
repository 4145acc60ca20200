// The compressions of simulators' files, over memory.
#pragma once

#include <cstdint>
#include <span>

#include "capture/zip.hpp"

namespace biss::capture {

enum class Packing : std::uint8_t { zlib, gzip, lz4, fastlz };

/// A packed byte makes at most this many bytes, in any of these compressions.
inline constexpr std::uint64_t max_packing_ratio = max_deflate_ratio;

/// Whether `packed` is whole and makes exactly `into.size()` bytes, which are then in `into`.
bool unpack(Packing packing, std::span<const std::uint8_t> packed, std::span<std::uint8_t> into,
            Inflater& inflater);

}  // namespace biss::capture
