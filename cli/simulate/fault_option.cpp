#include "cli/simulate/fault_option.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "cli/common/quantity.hpp"
#include "cli/common/verb.hpp"

namespace biss::cli {

namespace {

using sim::PlaceUnit;

using Checked = tl::expected<void, std::string>;

// A share from 0 to 1 in parts of 2^32, exact to 1e-9.
std::optional<std::uint64_t> read_share(std::string_view text) {
  constexpr std::uint64_t whole = std::uint64_t{1} << 32U;
  if (text == "1") return whole;
  if (text == "0") return 0;
  if (!text.starts_with("0.") || text.size() > 11 || text.size() < 3) return std::nullopt;
  std::uint64_t parts = 0;
  std::uint64_t unit = 1;
  for (const char c : text.substr(2)) {
    if (c < '0' || c > '9') return std::nullopt;
    parts = parts * 10 + static_cast<std::uint64_t>(c - '0');
    unit *= 10;
  }
  return (parts << 32U) / unit;
}

std::vector<std::string> simulated_names() {
  std::vector<std::string> names;
  for (const sim::FaultEntry& entry : sim::fault_list) {
    if (is_simulated(entry.kind)) names.emplace_back(entry.name);
  }
  return names;
}

std::string unknown_kind(const std::string& kind) {
  const std::string near = nearest(kind, simulated_names());
  if (!near.empty()) return fmt::format("--fault: no kind '{}'; did you mean {}?", kind, near);
  return fmt::format("--fault: no kind '{}'; the kinds are {}", kind, fault_kinds_text());
}

constexpr std::array<std::string_view, 2> unit_names{"bit", "clock"};

std::string_view unit_name(PlaceUnit unit) { return unit_names[static_cast<std::size_t>(unit)]; }

// A number with up to three decimals, in thousandths.
std::optional<std::uint64_t> read_thousandths(std::string_view text) {
  constexpr std::uint64_t most = 1'000'000'000;
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view decimals = text.substr(std::min(point + 1, text.size()));
  if (text.starts_with("0x") || decimals.size() > 3) return std::nullopt;
  if (point < text.size() && decimals.empty()) return std::nullopt;
  const auto whole = parse_count(text.substr(0, point), most);
  if (!whole.ok()) return std::nullopt;
  std::uint64_t thousandths = *whole;
  for (std::size_t i = 0; i < 3; ++i) {
    const char digit = i < decimals.size() ? decimals[i] : '0';
    if (digit < '0' || digit > '9') return std::nullopt;
    thousandths = thousandths * 10 + static_cast<std::uint64_t>(digit - '0');
  }
  return thousandths;
}

std::optional<sim::FaultPlace> read_place(std::string_view text) {
  for (const PlaceUnit unit : {PlaceUnit::bit, PlaceUnit::clock}) {
    const std::string_view name = unit_name(unit);
    if (!text.starts_with(name) || text.substr(name.size(), 1) != "=") continue;
    const auto thousandths = read_thousandths(text.substr(name.size() + 1));
    if (thousandths) return sim::FaultPlace{unit, *thousandths};
  }
  return std::nullopt;
}

// `12`, `12.25`.
std::string place_text(const sim::FaultPlace& place) {
  std::string text = fmt::format("{}={}", unit_name(place.unit), place.whole());
  if (place.thousandths % 1000 == 0) return text;
  text += fmt::format(".{:03}", place.thousandths % 1000);
  while (text.back() == '0') text.pop_back();
  return text;
}

Checked check_place(sim::FaultKind kind, const sim::FaultPlace& place,
                    const sim::NominalCycle& nominal) {
  const auto wrong = [](std::string text) { return tl::make_unexpected(std::move(text)); };
  const auto name = sim::name_of(kind);
  const sim::FaultPlaces places = places_of(kind, place.unit, nominal);
  if (places.contains(place)) return {};
  if (!sim::has_place(kind)) {
    return wrong(fmt::format("--fault: {} has no place: it affects the whole cycle", name));
  }
  if (places.empty()) {
    const PlaceUnit other = place.unit == PlaceUnit::bit ? PlaceUnit::clock : PlaceUnit::bit;
    if (places_of(kind, other, nominal).empty()) {
      return wrong(fmt::format("--fault: {} does not fit into this frame", name));
    }
    return wrong(fmt::format("--fault: {} takes a {}, not a {}", name, unit_name(other),
                             unit_name(place.unit)));
  }
  const std::string range =
      fmt::format("{} {} to {}", unit_name(place.unit), places.first, places.last);
  if (place.whole() < places.first || place.whole() > places.last) {
    return wrong(fmt::format("--fault: no {} for {}; on this line it takes {}", place_text(place),
                             name, range));
  }
  return wrong(fmt::format("--fault: {} takes a whole {}, not {}", name, unit_name(place.unit),
                           place_text(place)));
}

}  // namespace

std::string fault_kinds_text() { return fmt::format("{}", fmt::join(simulated_names(), ", ")); }

tl::expected<sim::FaultRule, std::string> read_fault(const std::string& text) {
  const auto wrong = [&text] {
    return tl::make_unexpected(fmt::format(
        "--fault: '{}' is not KIND:RATE with a rate of 0 to 1, nor KIND@CYCLE; either may end with "
        ",bit=N or ,clock=N",
        text));
  };
  const std::size_t mark = text.find_first_of(":@");
  if (mark == std::string::npos) return wrong();
  const std::string kind = text.substr(0, mark);
  const auto known = sim::find_fault(kind);
  if (!known || !is_simulated(*known)) return tl::make_unexpected(unknown_kind(kind));
  sim::FaultRule rule{.kind = *known};
  const std::size_t comma = std::min(text.find(',', mark), text.size());
  const std::string_view value = std::string_view(text).substr(mark + 1, comma - mark - 1);
  if (comma < text.size()) {
    rule.place = read_place(std::string_view(text).substr(comma + 1));
    if (!rule.place) return wrong();
  }
  if (text[mark] == '@') {
    const auto cycle = parse_count(value);
    if (!cycle.ok()) return wrong();
    rule.cycle = *cycle;
    return rule;
  }
  const auto share = read_share(value);
  if (!share) return wrong();
  rule.share = *share;
  return rule;
}

tl::expected<void, std::string> check_faults(std::span<const sim::FaultRule> rules,
                                             const sim::NominalCycle& nominal,
                                             std::uint64_t cycles) {
  for (std::size_t i = 0; i < rules.size(); ++i) {
    const sim::FaultRule& rule = rules[i];
    const auto same = [&](const sim::FaultRule& other) {
      return other.kind == rule.kind && other.cycle == rule.cycle;
    };
    if (rule.cycle && *rule.cycle >= cycles) {
      return tl::make_unexpected(fmt::format("--fault: no cycle {} for {}; the last one is {}",
                                             *rule.cycle, sim::name_of(rule.kind), cycles - 1));
    }
    if (std::any_of(rules.begin(), rules.begin() + static_cast<std::ptrdiff_t>(i), same)) {
      return tl::make_unexpected(
          fmt::format("--fault: {} is given twice{}; give each kind once", sim::name_of(rule.kind),
                      rule.cycle ? fmt::format(" for cycle {}", *rule.cycle) : " with a rate"));
    }
    if (!rule.place) continue;
    if (auto checked = check_place(rule.kind, *rule.place, nominal); !checked) return checked;
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

}  // namespace biss::cli
