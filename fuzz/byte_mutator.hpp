// The shared part of the mutators of binary captures.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "fuzz/capture_seeds.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

namespace biss::fuzz {

class ByteMutator {
 protected:
  explicit ByteMutator(std::uint64_t seed) : random_{seed} {}

  std::size_t below(std::size_t limit) { return static_cast<std::size_t>(random_() % limit); }

  /// Changed by libFuzzer, at most `growth` bytes longer.
  static std::string changed_bytes(std::string bytes, std::size_t growth) {
    const std::size_t size = bytes.size();
    bytes.resize(size + growth);
    bytes.resize(
        LLVMFuzzerMutate(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
    return bytes;
  }

  SplitMix random_;
};

/// A changed capture as the result of a custom mutator, in `data`. One that is too large is
/// replaced by `before`: without its end it could not be read.
inline std::size_t put_mutated(const std::string& changed, const std::string& before,
                               std::uint8_t* data, std::size_t max_size) {
  const std::string& result = changed.size() <= max_size ? changed : before;
  const std::size_t kept = std::min(result.size(), max_size);
  std::copy_n(result.begin(), kept, data);
  return kept;
}

}  // namespace biss::fuzz
