// Values of a data sheet's fields as people read and write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "biss/eds/field.hpp"

namespace biss::cli {

/// A value parsed, or the one line why not: `error` is empty exactly when `value` counts.
struct EdsValue {
  std::uint32_t value = 0;
  std::string error;
};

/// `12`, `0x21`, a name out of the field's table (`rotary`, `nE`), or a number with the field's
/// unit (`12 bit`, `10ms`, `233 K`). A time of the common part is a whole number of its steps
/// (`100ns`); where the step is a hypothesis a question mark must own up to it: `20us?`.
/// `linear` chooses between units that depend on EN_TYP.
EdsValue parse_eds_value(const EdsField& field, std::string_view text, bool linear);

/// The value for parse_eds_value(), as readable as it goes. No unit that is a hypothesis.
std::string eds_value_text(const EdsField& field, std::uint32_t value, bool linear);

/// What the value means, for eyes; empty where there is nothing to add to the number. Ends with
/// ` ?` where that is a hypothesis.
std::string eds_meaning(const EdsField& field, std::uint32_t value, bool linear);

}  // namespace biss::cli
