// Time, rate and length as types, so that a delay is never mistaken for a count of clocks.
#pragma once

#include <compare>
#include <cstdint>

namespace biss {

/// A point in time or a duration in picoseconds, signed; the range is 106 days either way.
struct Picoseconds {
  std::int64_t count = 0;

  constexpr auto operator<=>(const Picoseconds&) const = default;
  constexpr Picoseconds operator-() const { return {-count}; }
  constexpr Picoseconds& operator+=(Picoseconds other) {
    count += other.count;
    return *this;
  }
  constexpr Picoseconds& operator-=(Picoseconds other) {
    count -= other.count;
    return *this;
  }
};

constexpr Picoseconds operator+(Picoseconds a, Picoseconds b) { return {a.count + b.count}; }
constexpr Picoseconds operator-(Picoseconds a, Picoseconds b) { return {a.count - b.count}; }
constexpr Picoseconds operator*(Picoseconds a, std::int64_t n) { return {a.count * n}; }
constexpr Picoseconds operator*(std::int64_t n, Picoseconds a) { return {a.count * n}; }
constexpr Picoseconds operator/(Picoseconds a, std::int64_t n) { return {a.count / n}; }

constexpr Picoseconds picoseconds(std::int64_t n) { return {n}; }
constexpr Picoseconds nanoseconds(std::int64_t n) { return {n * 1'000}; }
constexpr Picoseconds microseconds(std::int64_t n) { return {n * 1'000'000}; }
constexpr Picoseconds milliseconds(std::int64_t n) { return {n * 1'000'000'000}; }

/// A rate in hertz: a clock frequency or cycles a second.
struct Hertz {
  std::uint32_t count = 0;

  constexpr auto operator<=>(const Hertz&) const = default;
};

constexpr Hertz hertz(std::uint32_t n) { return {n}; }
constexpr Hertz kilohertz(std::uint32_t n) { return {n * 1'000U}; }
constexpr Hertz megahertz(std::uint32_t n) { return {n * 1'000'000U}; }

inline constexpr std::int64_t picoseconds_per_second = 1'000'000'000'000;

/// Period of a rate, rounded to the nearest picosecond. A rate of 0 Hz has the period 0.
constexpr Picoseconds period_of(Hertz rate) {
  if (rate.count == 0) return {};
  return {(picoseconds_per_second + rate.count / 2) / rate.count};
}

/// Rate of a period, rounded to the nearest hertz; 0 Hz for a period that is not positive,
/// the largest rate (4.29 GHz) for a period too short for it.
constexpr Hertz rate_of(Picoseconds period) {
  if (period.count <= 0) return {};
  const std::int64_t rate = (picoseconds_per_second + period.count / 2) / period.count;
  return {rate > UINT32_MAX ? UINT32_MAX : static_cast<std::uint32_t>(rate)};
}

/// Whole clocks needed to cover a duration, rounded up; 0 for a duration that is not positive.
/// \pre period is positive.
constexpr std::int64_t clocks_to_cover(Picoseconds duration, Picoseconds period) {
  if (duration.count <= 0) return 0;
  return (duration.count + period.count - 1) / period.count;
}

/// A length in millimetres: a cable.
struct Millimetres {
  std::int64_t count = 0;

  constexpr auto operator<=>(const Millimetres&) const = default;
};

constexpr Millimetres millimetres(std::int64_t n) { return {n}; }
constexpr Millimetres metres(std::int64_t n) { return {n * 1'000}; }

}  // namespace biss
