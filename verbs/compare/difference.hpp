// The differences between two links, and their effects. docs/compare.md explains each property and
// its effect.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "verbs/compare/link.hpp"

namespace biss::verbs {

struct Difference {
  std::string property;
  /// Empty for words.
  std::string_view unit;
  std::variant<double, std::string> good;
  std::variant<double, std::string> bad;
  /// 0 to 1, two decimal places.
  double effect = 0;
};

/// All differences with an effect, the largest first. \pre both links have a request cycle
std::vector<Difference> differences(const Link& good, const Link& bad);

}  // namespace biss::verbs
