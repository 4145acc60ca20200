// Prints the confusion matrix of lab/reports/explain.md.
#include <fmt/format.h>

#include <cstdlib>

#include "tests/explain/matrix.hpp"

int main(int argc, char** argv) {
  using namespace biss::explain;
  const auto number = [&](int at, std::uint64_t otherwise) {
    return argc > at ? std::strtoull(argv[at], nullptr, 10) : otherwise;
  };
  const test::Matrix matrix =
      test::measure_matrix(number(1, test::documented_seed), number(2, test::documented_links),
                           number(3, test::documented_clean));
  fmt::print("{}", test::matrix_text(matrix));
  if (argc > 4) fmt::print("\n{}", matrix.misses);
}
