#include "verbs/simulate/fault_option.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "device/nearest.hpp"
#include "sim/fault_text.hpp"
#include "verbs/common/verb.hpp"

namespace biss::verbs {

namespace {

using sim::PlaceUnit;

std::string unknown_kind(const std::string& kind) {
  const std::string near = nearest(kind, sim::names_of(sim::is_injectable));
  if (!near.empty()) return fmt::format("--fault: no kind '{}'; did you mean {}?", kind, near);
  return fmt::format("--fault: no kind '{}'; the kinds are {}", kind, fault_kinds_text());
}

// `12`, `12.25`.
std::string place_text(const sim::FaultPlace& place) {
  std::string text = fmt::format("{}={}", name_of(place.unit), place.whole());
  if (place.thousandths % 1000 == 0) return text;
  text += fmt::format(".{:03}", place.thousandths % 1000);
  while (text.back() == '0') text.pop_back();
  return text;
}

std::string wrong_place(sim::FaultKind kind, const sim::FaultPlace& place,
                        const sim::NominalCycle& nominal) {
  const auto name = sim::name_of(kind);
  const sim::FaultPlaces places = places_of(kind, place.unit, nominal);
  if (places.contains(place)) return {};
  if (!sim::has_place(kind)) {
    return fmt::format("--fault: {} has no place: it affects the whole cycle", name);
  }
  if (places.empty()) {
    const PlaceUnit other = place.unit == PlaceUnit::bit ? PlaceUnit::clock : PlaceUnit::bit;
    if (places_of(kind, other, nominal).empty()) {
      return fmt::format("--fault: {} does not fit into this frame", name);
    }
    return fmt::format("--fault: {} takes a {}, not a {}", name, name_of(other),
                       name_of(place.unit));
  }
  const std::string range =
      fmt::format("{} {} to {}", name_of(place.unit), places.first, places.last);
  if (place.whole() < places.first || place.whole() > places.last) {
    return fmt::format("--fault: no {} for {}; on this line it takes {}", place_text(place), name,
                       range);
  }
  return fmt::format("--fault: {} takes a whole {}, not {}", name, name_of(place.unit),
                     place_text(place));
}

}  // namespace

std::string fault_kinds_text(bool (*is_offered)(sim::FaultKind)) {
  return fmt::format("{}", fmt::join(sim::names_of(is_offered), ", "));
}

tl::expected<sim::FaultRule, std::string> read_fault(const std::string& text) {
  const auto rule = sim::parse_fault(text);
  if (rule) return *rule;
  if (rule.error() == sim::FaultTextError::kind) {
    return tl::make_unexpected(unknown_kind(text.substr(0, text.find_first_of(":@"))));
  }
  return tl::make_unexpected(fmt::format(
      "--fault: '{}' is not KIND:RATE with a rate of 0 to 1, nor KIND@CYCLE; either may end with "
      ",bit=N or ,clock=N",
      text));
}

std::string wrong_faults(std::span<const sim::FaultRule> rules, const sim::NominalCycle& nominal,
                         std::uint64_t cycles) {
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const sim::FaultRule& rule = rules[i];
    const auto same = [&](const sim::FaultRule& other) {
      return other.kind == rule.kind && other.cycle == rule.cycle;
    };
    if (rule.cycle && *rule.cycle >= cycles) {
      return fmt::format("--fault: no cycle {} for {}; the last one is {}", *rule.cycle,
                         sim::name_of(rule.kind), cycles - 1);
    }
    if (std::any_of(rules.begin(), rules.begin() + static_cast<std::ptrdiff_t>(i), same)) {
      return fmt::format("--fault: {} is given twice{}; give each kind once",
                         sim::name_of(rule.kind),
                         rule.cycle ? fmt::format(" for cycle {}", *rule.cycle) : " with a rate");
    }
    if (!rule.place) continue;
    std::string wrong = wrong_place(rule.kind, *rule.place, nominal);
    if (!wrong.empty()) return wrong;
  }
  return {};
}

std::string text_of(std::span<const sim::InjectedFault> injected) {
  std::string text;
  for (const sim::InjectedFault& fault : injected) {
    if (!text.empty()) text += ';';
    text += fmt::format("{}@{}", sim::name_of(fault.kind), place_text(fault.place));
  }
  return text;
}

}  // namespace biss::verbs
