#include "sim/fault_text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>

namespace biss::sim {

namespace {

// Decimal, or hexadecimal after `0x`.
std::optional<std::uint64_t> read_count(std::string_view text) {
  const bool hexadecimal = text.starts_with("0x") || text.starts_with("0X");
  if (hexadecimal) text.remove_prefix(2);
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value, hexadecimal ? 16 : 10);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return value;
}

// A decimal number that begins and ends with a digit.
std::optional<double> read_decimal(std::string_view text) {
  if (text.empty() || text.find_first_not_of(".0123456789") != std::string_view::npos ||
      text.front() == '.' || text.back() == '.') {
    return std::nullopt;
  }
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return value;
}

std::optional<FaultPlace> read_place(std::string_view text) {
  for (const PlaceUnit unit : {PlaceUnit::bit, PlaceUnit::clock}) {
    const std::string_view name = name_of(unit);
    if (!text.starts_with(name) || text.substr(name.size(), 1) != "=") continue;
    const std::string_view number = text.substr(name.size() + 1);
    const std::size_t point = std::min(number.find('.'), number.size());
    const auto value = read_decimal(number);
    if (!value || number.size() - point > 4 || *value >= 1'000'000'001) return std::nullopt;
    return FaultPlace{unit, static_cast<std::uint64_t>(std::llround(*value * 1000))};
  }
  return std::nullopt;
}

}  // namespace

std::vector<std::string> names_of(bool (*is_offered)(FaultKind)) {
  std::vector<std::string> names;
  for (const FaultEntry& entry : fault_list) {
    if (is_offered(entry.kind)) names.emplace_back(entry.name);
  }
  return names;
}

tl::expected<FaultRule, FaultTextError> parse_fault(std::string_view text) {
  const auto wrong = tl::make_unexpected(FaultTextError::form);
  const std::size_t mark = text.find_first_of(":@");
  if (mark == std::string_view::npos) return wrong;
  const auto known = find_fault(text.substr(0, mark));
  if (!known || !is_injectable(*known)) return tl::make_unexpected(FaultTextError::kind);
  FaultRule rule{.kind = *known};
  const std::size_t comma = std::min(text.find(',', mark), text.size());
  const std::string_view value = text.substr(mark + 1, comma - mark - 1);
  if (comma < text.size()) {
    rule.place = read_place(text.substr(comma + 1));
    if (!rule.place) return wrong;
  }
  if (text[mark] == '@') {
    rule.cycle = read_count(value);
    if (!rule.cycle) return wrong;
    return rule;
  }
  const auto share = read_decimal(value);
  if (!share || *share > 1 || (value.size() > 1 && value[1] != '.')) return wrong;
  rule.share = static_cast<std::uint64_t>(std::ldexp(*share, 32));
  return rule;
}

}  // namespace biss::sim
