#include "verbs/decode/fail_on.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace biss::verbs {

namespace {

// The value of this name among the first `count` ones.
template <class Value>
std::optional<Value> named(std::string_view name, std::size_t count,
                           Value (*value_of)(std::size_t index)) {
  for (std::size_t i = 0; i < count; ++i) {
    if (name_of(value_of(i)) == name) return value_of(i);
  }
  return std::nullopt;
}

std::optional<SafetyVerdict> verdict_named(std::string_view name) {
  return named<SafetyVerdict>(name, safety_verdict_count, verdict_of);
}

std::optional<CycleStatus> status_named(std::string_view name) {
  if (name == name_of(CycleStatus::ok)) return std::nullopt;
  return named<CycleStatus>(name, cycle_status_count,
                            [](std::size_t i) { return static_cast<CycleStatus>(i); });
}

std::optional<decode::Limit> limit_named(std::string_view name) {
  return named<decode::Limit>(name, decode::limit_count,
                              [](std::size_t i) { return static_cast<decode::Limit>(i); });
}

// Rows with this cause; nothing if there is no such cause.
std::optional<std::uint64_t> rows_with(std::string_view cause, const decode::Statistics& all,
                                       const decode::SafetyWatch* safety) {
  if (cause == "any") return all.failed() + all.errors() + all.limited();
  if (cause == "nE") return all.errors();
  if (cause == "nW") return all.warnings();
  if (cause == "marginal") return all.marginal();
  if (cause == "limits") return all.limited();
  if (cause == "safety") return safety == nullptr ? 0 : safety->faults();
  if (const auto verdict = verdict_named(cause)) {
    return safety == nullptr ? 0 : safety->count(*verdict);
  }
  if (const auto status = status_named(cause)) return all.count(*status);
  if (const auto limit = limit_named(cause)) return all.count(*limit);
  return std::nullopt;
}

template <class Fits>
bool any_of(const FailOn& causes, Fits fits) {
  return std::any_of(causes.begin(), causes.end(), fits);
}

}  // namespace

std::string wrong_cause(const FailOn& causes) {
  for (const std::string& cause : causes) {
    if (rows_with(cause, {}, nullptr)) continue;
    return fmt::format(
        "--fail-on: '{}' is none of any, nE, nW, marginal, safety, its verdicts, limits, each of "
        "them and the causes of docs/status.md",
        cause);
  }
  return {};
}

bool asks_safety(const FailOn& causes) {
  return any_of(causes, [](const auto& each) { return each == "safety" || verdict_named(each); });
}

bool asks_format(const FailOn& causes) {
  return any_of(causes,
                [](const auto& each) { return each == "nE" || each == "nW" || each == "crc"; });
}

bool asks_line(const FailOn& causes) {
  return any_of(causes, [](const auto& each) {
    return each == "marginal" || each == "limits" || limit_named(each);
  });
}

std::optional<decode::Limit> unknown_limit(const FailOn& causes, const DeviceTiming& timing) {
  const decode::LimitWatch watch(timing);
  for (const std::string& cause : causes) {
    const auto limit = limit_named(cause);
    if (limit && !watch.knows(*limit)) return limit;
  }
  return std::nullopt;
}

bool is_met(const FailOn& causes, const decode::Statistics& statistics,
            const decode::SafetyWatch* safety) {
  return any_of(causes,
                [&](const auto& each) { return *rows_with(each, statistics, safety) != 0; });
}

}  // namespace biss::verbs
