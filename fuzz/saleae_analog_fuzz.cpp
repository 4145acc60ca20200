// Analog binary exports of Saleae Logic 2, two files as one capture: the reader on hostile bytes.
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "capture/saleae_analog.hpp"
#include "fuzz/capture_check.hpp"
#include "fuzz/scope_seeds.hpp"
#include "fuzz/two_files.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace {

void put(std::string& bytes, std::size_t at, std::uint64_t value, std::size_t count) {
  for (std::size_t i = 0; i < count && at + i < bytes.size(); ++i) {
    bytes[at + i] = static_cast<char>(value >> (8 * i));
  }
}

// A sample, a field of a header, or a few samples more or less.
void change(std::string& bytes, biss::fuzz::SplitMix& random) {
  const std::size_t at = random() % bytes.size();
  static constexpr float volts[] = {0.1F, 3.4F, 1.7F, -5.0F, 1e30F, -1e30F, 0.0F};
  static constexpr std::uint64_t fields[] = {0, 1, 2, 100, 1ULL << 63, 1'000, ~std::uint64_t{0}};
  switch (random() % 8) {
    case 0:
      return put(bytes, 12 + random() % 56 / 8 * 8, fields[random() % std::size(fields)], 8);
    case 1:
      bytes.erase(at, 4 * (random() % 8));
      return;
    case 2:
      bytes.insert(at, bytes.substr(at, 4 * (random() % 8)));
      return;
    case 3:
      return put(bytes, at, random(), 1 + random() % 8);
    default: {
      // Samples begin at a multiple of four in each version.
      const std::size_t sample = at / 4 * 4;
      const auto bits = std::bit_cast<std::uint32_t>(volts[random() % std::size(volts)]);
      const std::size_t run = 1 + random() % 4;
      for (std::size_t i = 0; i < run; ++i) put(bytes, sample + 4 * i, bits, 4);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  biss::fuzz::check_blocks(input, [input](std::size_t block) {
    return biss::fuzz::open_files(biss::fuzz::split_files(input), [block](std::string_view bytes) {
      return open_saleae_analog(biss::capture::memory_bytes(bytes, block), "analog", {});
    });
  });
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  constexpr std::size_t smallest_capture = 64;
  if (seed % 16 == 0 && size != 0) return LLVMFuzzerMutate(data, size, max_size);
  biss::fuzz::SplitMix random{seed};
  const bool fresh = size < smallest_capture || seed % 8 == 1;
  std::string bytes = fresh ? biss::fuzz::saleae_analog_seed(seed)
                            : std::string(reinterpret_cast<const char*>(data), size);
  const std::size_t changes = 1 + random() % 3;
  for (std::size_t i = 0; i < changes && !bytes.empty(); ++i) change(bytes, random);
  const std::size_t kept = std::min(bytes.size(), max_size);
  std::memcpy(data, bytes.data(), kept);
  return kept;
}
