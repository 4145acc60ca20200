// The findings of a check, for its tests.
#pragma once

#include <string>

#include "decode/check.hpp"

namespace biss::decode::test {

/// The rules that fail, by name.
inline std::string failing_rules(const Check& check) {
  std::string names;
  for (std::size_t i = 0; i < rule_count; ++i) {
    const auto rule = static_cast<Rule>(i);
    if (check.result(rule).verdict != Verdict::fail) continue;
    names += names.empty() ? "" : " ";
    names += text_of(rule).name;
  }
  return names;
}

}  // namespace biss::decode::test
