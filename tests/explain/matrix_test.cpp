// Captures of every cause, as many as docs/explain.md has.
#include "tests/explain/matrix.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace biss::explain::test {
namespace matrix_test {

TEST(ExplainMatrix, TrueCause_IsFirstIn95PercentAndAmongTwoIn99) {
  const Matrix matrix = measure_matrix(documented_seed, documented_links, documented_clean);
  std::uint64_t first = 0;
  std::uint64_t among_two = 0;
  std::uint64_t all = 0;
  for (std::size_t c = 1; c < cause_count; ++c) {
    first += matrix.right(static_cast<Cause>(c));
    among_two += matrix.among_two[c];
    all += matrix.links[c];
  }
  EXPECT_GE(100 * first, 95 * all) << matrix.misses;
  EXPECT_GE(100 * among_two, 99 * all) << matrix.misses;
  EXPECT_EQ(matrix.right(Cause::healthy), documented_clean) << matrix.misses;
  std::ifstream file(BISS_EXPLAIN_DOCUMENT);
  std::stringstream document;
  document << file.rdbuf();
  EXPECT_NE(document.str().find(matrix_text(matrix)), std::string::npos)
      << "print it with make explain-matrix";
}

}  // namespace matrix_test
}  // namespace biss::explain::test
