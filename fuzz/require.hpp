// Conditions that hold for every input.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace biss::fuzz {

/// Reports a finding with file and line unless `holds`.
inline void require(bool holds, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (holds) return;
  std::fprintf(stderr, "%s:%d: does not hold\n", file, line);
  std::abort();
}

}  // namespace biss::fuzz
