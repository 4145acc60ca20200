// Tests that try more in a long run.
#pragma once

#include <cstdint>
#include <cstdlib>

namespace biss::test {

/// True if the environment has BISS_LONG, as in stages of `make test-long` and
/// `make test-release`.
inline bool long_run() { return std::getenv("BISS_LONG") != nullptr; }

/// Rounds of a loop: `full` in a long run, otherwise `few`.
inline std::uint64_t rounds(std::uint64_t full, std::uint64_t few) {
  return long_run() ? full : few;
}

}  // namespace biss::test
