#include "verbs/decode/fail_on.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>

namespace biss::verbs {

namespace {

// Adds the value of that name to `values`. False if none of the first `count` values has it.
template <class Value>
bool add_named(std::string_view name, std::size_t count, Value (*value_of)(std::size_t index),
               std::vector<Value>& values) {
  for (std::size_t i = 0; i < count; ++i) {
    if (name_of(value_of(i)) != name) continue;
    values.push_back(value_of(i));
    return true;
  }
  return false;
}

template <class Enumerator>
Enumerator enumerator(std::size_t index) {
  return static_cast<Enumerator>(index);
}

}  // namespace

std::string FailOn::read(const std::vector<std::string>& words) {
  const std::map<std::string_view, bool*> single{{"any", &any_},       {"nE", &error_},
                                                 {"nW", &warning_},    {"marginal", &marginal_},
                                                 {"safety", &safety_}, {"limits", &limits_}};
  for (const std::string& word : words) {
    if (const auto found = single.find(word); found != single.end()) {
      *found->second = true;
      continue;
    }
    const bool known = add_named(word, safety_verdict_count, verdict_of, verdicts_) ||
                       (word != name_of(CycleStatus::ok) &&
                        add_named(word, cycle_status_count, enumerator<CycleStatus>, statuses_)) ||
                       add_named(word, decode::limit_count, enumerator<decode::Limit>, each_limit_);
    if (known) continue;
    return fmt::format(
        "--fail-on: '{}' is none of any, nE, nW, marginal, safety, its verdicts, limits, each of "
        "them and the causes of docs/status.md",
        word);
  }
  return {};
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
