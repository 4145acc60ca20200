// How often each cause is found, over captures of every cause.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "device/words.hpp"

namespace biss::explain::test {

// The seeds of the documented figures. The tables in explain/diagnose.cpp were made with others.
inline constexpr std::uint64_t documented_seed = 2'000'000;
inline constexpr std::uint64_t documented_links = 50;
inline constexpr std::uint64_t documented_clean = 1000;

struct Matrix {
  /// By true cause and the cause found first.
  std::array<std::array<std::uint64_t, cause_count>, cause_count> first{};
  /// By true cause: captures with it first, and among the first two.
  std::array<std::uint64_t, cause_count> links{};
  std::array<std::uint64_t, cause_count> among_two{};
  /// A line for each capture whose cause is not first.
  std::string misses;

  std::uint64_t right(Cause cause) const {
    const auto c = static_cast<std::size_t>(cause);
    return first[c][c];
  }
};

/// \param links captures of each cause, \param clean captures with nothing wrong
Matrix measure_matrix(std::uint64_t seed, std::uint64_t links, std::uint64_t clean);

/// The table of lab/reports/explain.md.
std::string matrix_text(const Matrix& matrix);

}  // namespace biss::explain::test
