// The reader of GHW on hostile strings, types, hierarchies and cycles.
#include "capture/ghw.hpp"

#include <cstddef>
#include <cstdint>
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
  return biss::fuzz::put_mutated(biss::fuzz::GhwMutator(seed).mutate(file), file, data, max_size);
}
