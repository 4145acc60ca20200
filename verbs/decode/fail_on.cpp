#include "verbs/decode/fail_on.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace biss::verbs {

std::string FailOn::read(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    if (word == "any") {
      any_ = true;
    } else if (word == "nE") {
      error_ = true;
    } else if (word == "nW") {
      warning_ = true;
    } else if (word == "marginal") {
      marginal_ = true;
    } else if (word == "safety") {
      safety_ = true;
    } else if (word == "limits") {
      limits_ = true;
    } else if (const auto verdict = safety_verdict_of(word)) {
      verdicts_.push_back(*verdict);
    } else if (!read_status(word) && !read_limit(word)) {
      return fmt::format(
          "--fail-on: '{}' is none of any, nE, nW, marginal, safety, its verdicts, limits, each of "
          "them and the causes of docs/status.md",
          word);
    }
  }
  return {};
}

bool FailOn::read_status(const std::string& word) {
  for (std::size_t i = 1; i < cycle_status_count; ++i) {
    const auto status = static_cast<CycleStatus>(i);
    if (name_of(status) != word) continue;
    statuses_.push_back(status);
    return true;
  }
  return false;
}

bool FailOn::read_limit(const std::string& word) {
  for (std::size_t i = 0; i < decode::limit_count; ++i) {
    const auto limit = static_cast<decode::Limit>(i);
    if (name_of(limit) != word) continue;
    each_limit_.push_back(limit);
    return true;
  }
  return false;
}

std::optional<decode::Limit> FailOn::unknown_limit(const DeviceTiming& timing) const {
  const decode::LimitWatch watch(timing);
  const auto unknown = std::find_if_not(each_limit_.begin(), each_limit_.end(),
                                        [&](decode::Limit limit) { return watch.knows(limit); });
  return unknown == each_limit_.end() ? std::nullopt : std::optional(*unknown);
}

bool FailOn::asks_format() const {
  return error_ || warning_ ||
         std::find(statuses_.begin(), statuses_.end(), CycleStatus::crc) != statuses_.end();
}

bool FailOn::met_by(const decode::Statistics& statistics, const decode::SafetyWatch* safety) const {
  if (safety != nullptr) {
    if (safety_ && safety->faults() != 0) return true;
    const auto is_seen = [&](SafetyVerdict verdict) { return safety->count(verdict) != 0; };
    if (std::any_of(verdicts_.begin(), verdicts_.end(), is_seen)) return true;
  }
  if (any_ && statistics.failed() != 0) return true;
  if ((error_ || any_) && statistics.errors() != 0) return true;
  if (warning_ && statistics.warnings() != 0) return true;
  if (marginal_ && statistics.marginal() != 0) return true;
  if ((limits_ || any_) && statistics.limited() != 0) return true;
  if (std::any_of(each_limit_.begin(), each_limit_.end(),
                  [&](auto limit) { return statistics.count(limit) != 0; })) {
    return true;
  }
  return std::any_of(statuses_.begin(), statuses_.end(),
                     [&](auto status) { return statistics.count(status) != 0; });
}

}  // namespace biss::verbs
