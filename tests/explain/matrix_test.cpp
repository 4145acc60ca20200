// Captures of every cause, many of each.
#include "tests/explain/matrix.hpp"

#include <gtest/gtest.h>

namespace biss::explain::test::matrix_test {

TEST(ExplainMatrix, TrueCause_IsFirstInMostCaptures) {
  const Matrix matrix = measure_matrix(documented_seed, documented_links, documented_clean);
  std::uint64_t first = 0;
  std::uint64_t among_two = 0;
  std::uint64_t all = 0;
  for (std::size_t c = 1; c < cause_count; ++c) {
    first += matrix.right(static_cast<Cause>(c));
    among_two += matrix.among_two[c];
    all += matrix.links[c];
  }
  EXPECT_GE(100 * first, 85 * all) << matrix.misses;
  EXPECT_GE(100 * among_two, 88 * all) << matrix.misses;
  EXPECT_GE(100 * matrix.right(Cause::healthy), 98 * documented_clean) << matrix.misses;
}

}  // namespace biss::explain::test::matrix_test
