#include "capture/edge_source.hpp"

#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "capture/pair_source.hpp"

namespace biss::capture {

std::unique_ptr<PairSource> EdgeSource::pairs(wire::LineIndex /*ma*/, wire::LineIndex /*slo*/) {
  return nullptr;
}

void StepSource::set_lines(std::vector<std::string> lines) {
  lines_ = unique_names(std::move(lines));
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

std::vector<std::string> unique_names(std::vector<std::string> names) {
  std::unordered_set<std::string> taken;
  std::unordered_map<std::string, std::uint32_t> asked;
  for (std::string& name : names) {
    if (taken.insert(name).second) continue;
    // Numbering continues from the last number, so equal names cost as much as different names.
    std::uint32_t& number = asked.try_emplace(name, 1U).first->second;
    const std::string wanted = name + '#';
    do {
      name = wanted + std::to_string(++number);
    } while (!taken.insert(name).second);
  }
  return names;
}

}  // namespace biss::capture
