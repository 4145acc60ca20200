// The share of a sweep: all of it in an optimised build, a part of it in a slow one.
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

/// One of `thin` cases is tested. A prime, so that every value of each dimension of a sweep occurs.
inline constexpr std::uint64_t thin = slow_build ? 31 : 1;

/// Rounds of a random test.
constexpr std::uint64_t rounds(std::uint64_t full) { return full / thin + 1; }

}  // namespace exhaustive
