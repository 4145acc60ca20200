// What must hold, whatever the input was.
#pragma once

#include <cstdio>
#include <cstdlib>

namespace biss::fuzz {

/// A finding unless `holds`; says which line is broken.
inline void require(bool holds, const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
  if (holds) return;
  std::fprintf(stderr, "%s:%d: does not hold\n", file, line);
  std::abort();
}

}  // namespace biss::fuzz
