// The figures of a link between a master and an encoder: counts that add up, and measured
// quantities.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "decode/cycle.hpp"
#include "decode/limits.hpp"
#include "decode/statistics.hpp"

namespace biss::archive {

/// The quantities that are measured in the cycles of a capture. Times are in picoseconds.
enum class Quantity : std::uint8_t { period, interval, line_delay, ack, ack_clocks, duty };

inline constexpr std::size_t quantity_count = 6;

/// Users and scripts see the names; docs/archive.md explains each.
constexpr std::string_view name_of(Quantity quantity) {
  constexpr std::array<std::string_view, quantity_count> names{
      "period_ps", "interval_ps", "line_delay_ps", "ack_ps", "ack_clocks", "duty_per_mille"};
  return names[static_cast<std::size_t>(quantity)];
}

const decode::Distribution& distribution_of(const decode::Statistics& statistics,
                                            Quantity quantity);

/// Counts of request cycles, with the same names as in decode::Statistics.
struct Counts {
  std::uint64_t cycles = 0;
  std::array<std::uint64_t, cycle_status_count> by_status{};
  std::uint64_t errors = 0;
  std::uint64_t warnings = 0;
  std::array<std::uint64_t, decode::limit_count> by_limit{};
  std::uint64_t limited = 0;
  std::uint64_t marginal = 0;
  std::uint64_t margin_judged = 0;

  bool operator==(const Counts&) const = default;
  void add(const Counts& other);
  std::uint64_t count(CycleStatus status) const {
    return by_status[static_cast<std::size_t>(status)];
  }
  /// Cycles with a named cause: neither good nor cut by an end of the capture.
  std::uint64_t faults() const;
  /// The most frequent cause; `ok` if there is no fault.
  CycleStatus foremost_fault() const;
};

Counts counts_of(const decode::Statistics& statistics);

/// A measured quantity in one capture.
struct Range {
  std::int64_t min = 0;
  /// As decode::Distribution::median().
  std::int64_t median = 0;
  std::int64_t max = 0;
  bool operator==(const Range&) const = default;
};

}  // namespace biss::archive
