// The reader of FST on hostile sections, indexes, chains and times.
#include "capture/fst.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "fuzz/capture_check.hpp"
#include "fuzz/fst_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view file(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(file, biss::capture::open_fst);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  const std::string file(reinterpret_cast<const char*>(data), size);
  const std::string changed = biss::fuzz::FstMutator(seed).mutate(file);
  // Without its end a file has no names, so one that is too large is replaced by the original.
  const std::string& result = changed.size() <= max_size ? changed : file;
  const std::size_t kept = std::min(result.size(), max_size);
  std::memcpy(data, result.data(), kept);
  return kept;
}
