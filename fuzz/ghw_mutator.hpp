// Mutations of a GHW, mostly of the cycles, so that signals remain that can change.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "capture/test_ghw.hpp"
#include "fuzz/byte_mutator.hpp"
#include "fuzz/capture_seeds.hpp"

namespace biss::fuzz {

/// Request cycles as a GHW of either version and byte order.
inline std::string ghw_seed(std::uint64_t seed) {
  return capture::ghw_of({"MA", "SLO"}, cycle_edges(seed, cycles_of(seed)),
                         static_cast<unsigned>(seed % 2), seed % 4 == 2);
}

/// A GHW with an array, a record and a generate before its end of the header.
inline std::string ghw_composite_seed() {
  using namespace std::string_view_literals;
  capture::GhwText text = capture::ghw_start();
  text.strings({"'0'", "'1'", "bit", "int", "vec", "rec", "a", "v", "MA", "SLO", "time", "fs"});
  text.section("TYP");
  text.word(7);
  text.put(
      "\x16\3\2\1\2\x19\4\x1F\5\1\1\2\x23\5\3\x99\3\2\x20\6\2\7\1\x08\4\x1D\x0B\1\x0C\1\x22"
      "\3\1\x16\0\1"sv);
  text.byte(0);
  text.section("WKT");
  text.put("\2\1\0"sv);
  text.section("HIE");
  for (const std::uint32_t count : {2U, 4U, 8U}) text.word(count);
  text.put(
      "\6\6\x10\x09\4\1\2\5\7\2\3\x10\x0A\2\3\x0D\6\x0F\x10\6\5\4\5\6\x0F\0EOH\0SNP\0\0\0\0\0"sv);
  text.time(0);
  text.put("\1\1\5\0\1\1ESN\0CYC\0"sv);
  text.time(0);
  for (int i = 0; i < 30; ++i) {
    text.put("\1\0\0\x0A\1\1\0\x0A"sv);
  }
  text.put(
      "\0\x7F"
      "ECY\0"sv);
  return text.text();
}

class GhwMutator final : public ByteMutator {
 public:
  explicit GhwMutator(std::uint64_t seed) : ByteMutator(seed) {}

  std::string mutate(std::string file) {
    const std::size_t kind = below(32);
    if (kind == 0) return changed_bytes(std::move(file), 16);
    std::size_t cycles = file.find("CYC");
    if (cycles == std::string::npos || kind == 1) {
      file = below(4) == 0 ? ghw_composite_seed() : ghw_seed(random_());
      cycles = file.find("CYC");
    }
    std::string header = file.substr(0, cycles);
    std::string values = file.substr(cycles);
    if (kind < 6) {
      header = below(2) == 0 ? changed_bytes(std::move(header), 16) : changed_byte(header, 0);
    } else if (kind < 10) {
      values = changed_bytes(std::move(values), 16);
    } else if (kind < 28) {
      values = changed_byte(std::move(values), 12);
    } else {
      values = changed_length(std::move(values));
    }
    return header + values;
  }

 private:
  std::string changed_byte(std::string bytes, std::size_t first) {
    if (bytes.size() <= first) return bytes;
    const std::size_t at = first + below(bytes.size() - first);
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
    return bytes;
  }

  // Doubles or removes a stretch: of cycles, mostly.
  std::string changed_length(std::string bytes) {
    const std::size_t at = below(bytes.size());
    const std::size_t count = std::min(bytes.size() - at, 1 + below(64));
    if (below(2) == 0) {
      bytes.insert(at, bytes.substr(at, count));
    } else {
      bytes.erase(at, count);
    }
    return bytes;
  }
};

}  // namespace biss::fuzz
