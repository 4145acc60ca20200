// The reader of GHW on hostile strings, types, hierarchies and cycles.
#include "capture/ghw.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "fuzz/capture_check.hpp"
#include "fuzz/ghw_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(file, biss::capture::open_ghw);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  const std::string file(reinterpret_cast<const char*>(data), size);
  const std::string changed = biss::fuzz::GhwMutator(seed).mutate(file);
  const std::size_t kept = std::min(changed.size(), max_size);
  std::memcpy(data, changed.data(), kept);
  return kept;
}
