#include "capture/edge_source.hpp"

#include "capture/pair_source.hpp"

namespace biss::capture {

std::unique_ptr<PairSource> EdgeSource::pairs(wire::LineIndex /*ma*/, wire::LineIndex /*slo*/) {
  return nullptr;
}

std::string LineNames::claim(const std::string& wanted) {
  if (taken_.insert(wanted).second) return wanted;
  // Numbering continues from the last number, so equal names cost as much as different names.
  std::uint32_t& number = asked_.try_emplace(wanted, 1U).first->second;
  for (;;) {
    std::string name = wanted + '#' + std::to_string(++number);
    if (taken_.insert(name).second) return name;
  }
}

}  // namespace biss::capture
