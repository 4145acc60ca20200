// Punctuation that no machine-readable text may follow.
#pragma once

#include <locale>
#include <string>

namespace biss::test {

/// A comma in fractions, dots between groups of three digits.
struct GermanPunctuation : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

}  // namespace biss::test
