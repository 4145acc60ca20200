#include "sim/fault_text.hpp"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <optional>

namespace biss::sim {

namespace {

bool is_hexadecimal(std::string_view text) {
  return text.starts_with("0x") || text.starts_with("0X");
}

// Decimal, or hexadecimal after `0x`.
std::optional<std::uint64_t> read_count(std::string_view text) {
  const bool hexadecimal = is_hexadecimal(text);
  if (hexadecimal) text.remove_prefix(2);
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value, hexadecimal ? 16 : 10);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return value;
}

// A share from 0 to 1 in parts of 2^32, exact to 1e-9: further digits have no effect.
std::optional<std::uint64_t> read_share(std::string_view text) {
  constexpr std::uint64_t whole = std::uint64_t{1} << 32U;
  if (text == "1") return whole;
  if (text == "0") return 0;
  if (!(text.starts_with("0.") || text.starts_with("1.")) || text.size() < 3) return std::nullopt;
  std::uint64_t parts = 0;
  std::uint64_t unit = 1;
  bool all_zeros = true;
  for (const char c : text.substr(2)) {
    if (c < '0' || c > '9') return std::nullopt;
    all_zeros = all_zeros && c == '0';
    if (unit == 1'000'000'000) continue;
    parts = parts * 10 + static_cast<std::uint64_t>(c - '0');
    unit *= 10;
  }
  if (text.front() == '0') return (parts << 32U) / unit;
  if (!all_zeros) return std::nullopt;
  return whole;
}

// A decimal number with up to three decimals, in thousandths.
std::optional<std::uint64_t> read_thousandths(std::string_view text) {
  constexpr std::uint64_t most = 1'000'000'000;
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view decimals = text.substr(std::min(point + 1, text.size()));
  if (is_hexadecimal(text) || decimals.size() > 3) return std::nullopt;
  if (point < text.size() && decimals.empty()) return std::nullopt;
  const auto whole = read_count(text.substr(0, point));
  if (!whole || *whole > most) return std::nullopt;
  std::uint64_t thousandths = *whole;
  for (std::size_t i = 0; i < 3; ++i) {
    const char digit = i < decimals.size() ? decimals[i] : '0';
    if (digit < '0' || digit > '9') return std::nullopt;
    thousandths = thousandths * 10 + static_cast<std::uint64_t>(digit - '0');
  }
  return thousandths;
}

std::optional<FaultPlace> read_place(std::string_view text) {
  for (const PlaceUnit unit : {PlaceUnit::bit, PlaceUnit::clock}) {
    const std::string_view name = name_of(unit);
    if (!text.starts_with(name) || text.substr(name.size(), 1) != "=") continue;
    const auto thousandths = read_thousandths(text.substr(name.size() + 1));
    if (thousandths) return FaultPlace{unit, *thousandths};
  }
  return std::nullopt;
}

}  // namespace

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
  const auto share = read_share(value);
  if (!share) return wrong;
  rule.share = *share;
  return rule;
}

}  // namespace biss::sim
