// How a quantity changes over the days of an archive.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "archive/date.hpp"
#include "archive/entry.hpp"

namespace biss::archive {

/// The value of a quantity in one capture.
struct DatedValue {
  Day day = 0;
  std::int64_t value = 0;
};

/// The slope of the line of least squares through the values, in units a year of 365 days, rounded.
/// Nothing if all values are of one day. The result is exact, so it is the same on every machine.
/// Values above 2^53 count as 2^53.
std::optional<std::int64_t> change_per_year(std::span<const DatedValue> values);

/// A link of a capture, and the file it is in, which has a day.
struct PlacedLink {
  const FileEntry* file = nullptr;
  const LinkEntry* link = nullptr;
};

/// The medians of a quantity, a value for each capture that has it.
std::vector<DatedValue> medians_of(std::span<const PlacedLink> captures, Quantity quantity);
/// Faults in a million cycles, a value for each capture with cycles.
std::vector<DatedValue> fault_rates_of(std::span<const PlacedLink> captures);

/// The captures of one day.
struct DayFigures {
  Day day = 0;
  std::uint64_t captures = 0;
  Counts counts;
  /// By Quantity: the lower median of the medians of the captures.
  std::array<std::optional<std::int64_t>, quantity_count> medians;
};

/// In the order of the days.
std::vector<DayFigures> days_of(std::span<const PlacedLink> captures);

}  // namespace biss::archive
