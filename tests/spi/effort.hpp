// The effort of a long test in this build.
#pragma once

namespace biss::test::spi {

#if defined(__SANITIZE_ADDRESS__)
#define BISS_SPI_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(undefined_behavior_sanitizer)
#define BISS_SPI_SANITIZED
#endif
#endif

/// True in slow builds: instrumented or not optimised.
#if defined(BISS_SPI_SANITIZED) || !defined(__OPTIMIZE__)
inline constexpr bool slow_build = true;
#else
inline constexpr bool slow_build = false;
#endif

}  // namespace biss::test::spi
