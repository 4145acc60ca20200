#include "device/nearest.hpp"

#include <algorithm>
#include <cstddef>

namespace biss {

namespace {

// Changes, insertions, deletions and swaps of neighbours that make one word of the other.
std::size_t typing_slips(const std::string& a, const std::string& b) {
  // [i][j]: for the first i characters of a and the first j characters of b.
  std::vector<std::vector<std::size_t>> slips(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t j = 0; j <= b.size(); ++j) slips[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    slips[i][0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = slips[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0U : 1U);
      slips[i][j] = std::min({change, slips[i - 1][j] + 1, slips[i][j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) slips[i][j] = std::min(slips[i][j], slips[i - 2][j - 2] + 1);
    }
  }
  return slips[a.size()][b.size()];
}

}  // namespace

std::string nearest(const std::string& name, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest_name = 64;
  if (name.size() > longest_name) return {};
  std::size_t fewest = std::max<std::size_t>(1, name.size() / 3);
  std::string best;
  for (const std::string& candidate : candidates) {
    const bool shortened = name.size() >= 3 && candidate.starts_with(name);
    const std::size_t slips = shortened ? 1 : typing_slips(name, candidate);
    if (slips > fewest || (slips == fewest && !best.empty())) continue;
    fewest = slips;
    best = candidate;
  }
  return best;
}

}  // namespace biss
