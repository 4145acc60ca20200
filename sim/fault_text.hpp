// A fault rule as text: its kind, its cycles, and its place in a cycle.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "sim/fault.hpp"

namespace biss::sim {

/// Why a text is not a fault rule.
enum class FaultTextError : std::uint8_t {
  form,  ///< neither KIND:RATE nor KIND@CYCLE, or not a valid place
  kind,  ///< no kind that the line model can inject has this name
};

/// Reads `KIND:RATE`, a share of cycles from 0 to 1, or `KIND@CYCLE`. Either may end with `,bit=N` or
/// `,clock=N`, N with up to three decimal places. Only CYCLE may be hexadecimal, after `0x`.
tl::expected<FaultRule, FaultTextError> parse_fault(std::string_view text);

/// The names of the kinds that are offered.
std::vector<std::string> names_of(bool (*is_offered)(FaultKind));

/// The name of a place's unit in such a text: "bit", "clock".
constexpr std::string_view name_of(PlaceUnit unit) {
  return unit == PlaceUnit::bit ? "bit" : "clock";
}

}  // namespace biss::sim
