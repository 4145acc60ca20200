// Prints the confusion tables of lab/reports/identify.md: biss_protocol_table [SEED…]
#include <fmt/format.h>

#include <cstdlib>

#include "tests/other_lines/score.hpp"

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::uint64_t seed = std::strtoull(argv[i], nullptr, 10);
    const biss::other_lines::Score score = biss::other_lines::score(seed, 1000, 500);
    fmt::print("{}", biss::other_lines::table_of(score));
    fmt::print(stderr, "{}", score.wrong);
  }
}
