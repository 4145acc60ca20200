// Decimal numbers to whole units, exactly: no floating point on the way.
#pragma once

#include <cstdint>
#include <string_view>

#include "biss/base/result.hpp"

namespace biss::capture {

enum class DecimalCause : std::uint8_t { no_number, out_of_range };

/// `text` × 10^`scale`, rounded to a whole number, halves away from zero.
///
/// Sign, digits with or without a fraction, exponent (`-1.5e-3`); at least one digit; `.` and, when
/// `comma` is set, `,` as decimal mark. Any number of digits. Fails with `no_number`, or with
/// `out_of_range` when the result is beyond ±(2⁶³ − 1).
Result<std::int64_t, DecimalCause> parse_decimal(std::string_view text, int scale,
                                                 bool comma = false);

}  // namespace biss::capture
