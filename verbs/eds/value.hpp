// Values of a data sheet's fields as people read and write them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "biss/eds/field.hpp"

namespace biss::verbs {

/// The value of a text, or one line why it has none. A text is `12`, `0x21`, a name from the field's
/// table (`rotary`, `nE`), or a number with the field's unit (`12 bit`, `10ms`, `233 K`). A time of
/// the common part is a whole number of its steps (`100ns`); if the step is a hypothesis, a
/// question mark must confirm it: `20us?`. `linear` selects between units that depend on EN_TYP.
tl::expected<std::uint32_t, std::string> parse_eds_value(const EdsField& field,
                                                         std::string_view text, bool linear);

/// The value as text that parse_eds_value() reads, with its name or unit unless the unit is a
/// hypothesis.
std::string eds_value_text(const EdsField& field, std::uint32_t value, bool linear);

/// The meaning of a value, human-readable; empty if the number needs no explanation. Ends with ` ?`
/// if the meaning is a hypothesis.
std::string eds_meaning(const EdsField& field, std::uint32_t value, bool linear);

}  // namespace biss::verbs
