// Mutations of raw samples after their layout.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>

#include "fuzz/capture_seeds.hpp"
#include "fuzz/raw_header.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace biss::fuzz {

/// The custom mutator of a target that reads raw samples.
inline std::size_t mutate_raw(std::uint8_t* data, std::size_t size, std::size_t max_size,
                              unsigned seed) {
  SplitMix random{seed};
  std::string input(reinterpret_cast<const char*>(data), size);
  if (size <= raw_header_bytes || random() % 16 == 0) {
    const std::uint64_t number = random();
    input = raw_header(sampled_layout(number)) + raw_seed(number);
  }
  if (random() % 8 == 0) {
    input.resize(std::min(input.size(), max_size));
    std::memcpy(data, input.data(), input.size());
    return LLVMFuzzerMutate(data, input.size(), max_size);
  }
  // Damages the layout, or adds or removes a sample, so that a change comes earlier or later.
  const std::size_t samples = input.size() - raw_header_bytes;
  const std::size_t at = raw_header_bytes + random() % samples;
  switch (random() % 4) {
    case 0:
      input[random() % raw_header_bytes] ^= static_cast<char>(1U << random() % 8);
      break;
    case 1:
      input.insert(at, 1 + random() % 4, input[at]);
      break;
    case 2:
      if (samples > 8) input.erase(at, 1 + random() % 4);
      break;
    default:
      input[at] ^= static_cast<char>(1U << random() % 8);
  }
  const std::size_t kept = std::min(input.size(), max_size);
  std::memcpy(data, input.data(), kept);
  return kept;
}

}  // namespace biss::fuzz
