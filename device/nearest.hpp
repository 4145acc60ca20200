// The name that a user meant by a misspelt one.
#pragma once

#include <string>
#include <vector>

namespace biss {

/// The candidate that differs from `name` by the fewest typing slips, or that begins with `name`;
/// empty when none is near.
std::string nearest(const std::string& name, const std::vector<std::string>& candidates);

}  // namespace biss
