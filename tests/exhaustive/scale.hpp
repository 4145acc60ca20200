// How much of a sweep is done: all of it in an optimised build, a part where every step is slow.
#pragma once

#include <cstdint>

namespace exhaustive {

#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool slow_build = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr bool slow_build = true;
#elif defined(BISS_SLOW_BUILD)
inline constexpr bool slow_build = true;
#else
inline constexpr bool slow_build = false;
#endif
#elif defined(BISS_SLOW_BUILD)
inline constexpr bool slow_build = true;
#else
inline constexpr bool slow_build = false;
#endif

/// One of `thin` cases is tried. A prime, so that no dimension of a sweep is hit at one value only.
inline constexpr std::uint64_t thin = slow_build ? 31 : 1;

/// Rounds of a random test.
constexpr std::uint64_t rounds(std::uint64_t full) { return full / thin + 1; }

}  // namespace exhaustive
