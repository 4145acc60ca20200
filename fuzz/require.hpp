// What must hold, whatever the input was.
#pragma once

#include <cstdlib>

namespace biss::fuzz {

/// A finding unless `holds`.
inline void require(bool holds) {
  if (!holds) std::abort();
}

}  // namespace biss::fuzz
