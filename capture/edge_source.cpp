#include "capture/edge_source.hpp"

#include <utility>

#include "capture/pair_source.hpp"

namespace biss::capture {

std::unique_ptr<PairSource> EdgeSource::pairs(wire::LineIndex /*ma*/, wire::LineIndex /*slo*/) {
  return nullptr;
}

void StepSource::set_lines(std::vector<std::string> lines) {
  lines_ = std::move(lines);
  block_.prepare(2 * lines_.size());
}

void StepSource::renew_block() {
  block_.grow();
  block_.prepare(2 * lines_.size());
}

Result<std::span<const wire::Edge>, CaptureError> StepSource::next_block() {
  // Opening may have put edges into the first block.
  if (std::exchange(delivered_, true)) renew_block();
  while (!ended_ && block_.empty()) step();
  if (block_.empty() && error_) return failure(*error_);
  return block_.edges();
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
