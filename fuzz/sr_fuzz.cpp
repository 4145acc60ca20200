// The reader of sigrok sessions on hostile archives, metadata and samples.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "capture/sr.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/sr_mutator.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view archive(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_reader(archive, biss::capture::open_sr);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  const std::string archive(reinterpret_cast<const char*>(data), size);
  const std::string changed = biss::fuzz::SrMutator(seed).mutate(archive);
  // A truncated archive has no directory, so an archive that is too large is replaced by the
  // original.
  const std::string& result = changed.size() <= max_size ? changed : archive;
  const std::size_t kept = std::min(result.size(), max_size);
  std::memcpy(data, result.data(), kept);
  return kept;
}
