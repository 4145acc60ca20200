// The day on which a capture was taken.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace biss::archive {

/// Days since 1970-01-01.
using Day = std::int32_t;

/// The last date in a path, of a folder or of the file: `2024-03-17`, `2024_03_17`, `2024.03.17`,
/// `2024/03/17`, `20240317`, also followed by a time of six digits. Years 1990 to 2099.
std::optional<Day> day_in(std::string_view path);

/// \param time nanoseconds since 1970-01-01 00:00 UTC
Day day_of(std::int64_t time);

/// `2024-03-17`.
std::string day_text(Day day);
/// Reads the text of day_text(); nothing if it is not a date.
std::optional<Day> day_from(std::string_view text);

}  // namespace biss::archive
