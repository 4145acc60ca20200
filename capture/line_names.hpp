// Names of lines that no two lines share.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <unordered_set>

namespace biss::capture {

/// Hands out names; the second that asks for a name gets `name#2`, and so on.
class LineNames {
 public:
  /// `wanted`, or the first free of `wanted#2`, `wanted#3`, …
  std::string claim(const std::string& wanted);

 private:
  std::unordered_set<std::string> taken_;
  std::unordered_map<std::string, std::uint32_t> asked_;
};

}  // namespace biss::capture
