#include "identify/gf2.hpp"

#include <algorithm>

namespace biss::identify {

namespace {

struct Factor {
  std::uint32_t polynomial = 0;
  int power = 0;
};

// The irreducible factors with a constant term and a degree of at most `most`. Each polynomial is
// tried in rising order, so that one that divides what is left is irreducible.
std::vector<Factor> factors(Polynomial p, int most) {
  std::vector<Factor> found;
  p = without_x(p);
  for (std::uint32_t trial = 3; degree(trial) <= most && degree(p) > 0; trial += 2) {
    if (2 * degree(trial) > degree(p)) {
      // What is left has no factor of a smaller degree.
      if (degree(p) <= most) found.push_back({static_cast<std::uint32_t>(p), 1});
      break;
    }
    Factor factor{trial, 0};
    while (degree(p) > 0 && remainder(p, trial) == 0) {
      p = divided(p, trial).quotient;
      ++factor.power;
    }
    if (factor.power != 0) found.push_back(factor);
  }
  return found;
}

}  // namespace

std::vector<std::uint32_t> divisors(Polynomial p, int least, int most, std::size_t limit) {
  constexpr std::size_t products_at_most = 4096;
  std::vector<std::uint32_t> all{1};
  for (const Factor& factor : factors(p, most)) {
    const std::size_t known = all.size();
    Polynomial power = 1;
    for (int i = 0; i < factor.power; ++i) {
      power = product(power, factor.polynomial);
      for (std::size_t k = 0; k < known && all.size() < products_at_most; ++k) {
        const Polynomial next = degree(power) > most ? 0 : product(power, all[k]);
        if (next != 0 && degree(next) <= most) all.push_back(static_cast<std::uint32_t>(next));
      }
    }
  }
  std::erase_if(all, [least](std::uint32_t each) { return degree(each) < least; });
  std::sort(all.begin(), all.end(), std::greater<>());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (all.size() > limit) all.resize(limit);
  return all;
}

}  // namespace biss::identify
