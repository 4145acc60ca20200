#include "lab/campaign_fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/algorithm/string/classification.hpp>
#include <boost/algorithm/string/split.hpp>
#include <charconv>
#include <cmath>
#include <vector>

namespace biss::lab {
namespace {

constexpr std::string_view fitting_word = "fitting";

template <class Number>
std::optional<Number> number_of(std::string_view text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || at != end) return std::nullopt;
  return number;
}

std::optional<std::uint32_t> rate_of(std::string_view text) {
  const auto number = number_of<double>(text);
  if (!number || !(*number > 0) || *number > 0.5) return std::nullopt;
  const double parts = std::round(std::ldexp(*number, 32));
  if (parts < 1) return std::nullopt;
  return static_cast<std::uint32_t>(parts);
}

std::optional<FaultChoice> parse_flips(const std::vector<std::string_view>& parts) {
  if (parts.size() < 2 || parts.size() > 3) return std::nullopt;
  FaultChoice fault{.kind = FaultKind::flips};
  const auto rate = rate_of(parts[1]);
  if (!rate) return std::nullopt;
  fault.rate = *rate;
  if (parts.size() == 3) {
    fault.fitting = parts[2] == fitting_word;
    const auto drawn = fault.fitting ? 0U : rate_of(parts[2]);
    if (!drawn) return std::nullopt;
    fault.drawn_rate = *drawn;
  }
  return fault;
}

}  // namespace

std::optional<FaultChoice> parse_fault(std::string_view text) {
  std::vector<std::string_view> parts;
  boost::split(parts, text, boost::is_any_of(":"));
  FaultChoice fault;
  const auto kind = sim::find_fault(parts[0]);
  if (!kind ||
      std::find(campaign_faults.begin(), campaign_faults.end(), *kind) == campaign_faults.end()) {
    return std::nullopt;
  }
  fault.kind = *kind;
  if (fault.kind == FaultKind::flips) return parse_flips(parts);
  parts.erase(parts.begin());
  if (has_length(fault.kind)) {
    const auto length = parts.empty() ? std::nullopt : number_of<unsigned>(parts[0]);
    if (!length || *length < (fault.kind == FaultKind::burst ? 2U : 1U) || *length > max_burst_bits)
      return std::nullopt;
    fault.length_bits = *length;
    parts.erase(parts.begin());
  }
  if (parts.size() > 1) return std::nullopt;
  if (parts.empty()) return fault;
  if (is_around(fault.kind) && fault.kind != FaultKind::false_start) return std::nullopt;
  fault.place = number_of<unsigned>(parts[0]);
  if (!fault.place) return std::nullopt;
  return fault;
}

std::string text_of(const FaultChoice& fault) {
  std::string text(sim::name_of(fault.kind));
  // The fewest digits that parse to the same part of 2^32.
  const auto rate = [](std::uint32_t parts) {
    std::string digits;
    for (int count = 1; count <= 10 && rate_of(digits) != parts; ++count) {
      digits = fmt::format("{:.{}g}", static_cast<double>(probability_of(parts)), count);
    }
    return ":" + digits;
  };
  if (fault.kind == FaultKind::flips) {
    text += rate(fault.rate);
    if (fault.drawn_rate != 0) text += rate(fault.drawn_rate);
    if (fault.fitting) text += fmt::format(":{}", fitting_word);
  }
  if (has_length(fault.kind)) text += fmt::format(":{}", fault.length_bits);
  if (fault.place) text += fmt::format(":{}", *fault.place);
  return text;
}

}  // namespace biss::lab
