// Time, rate, length and voltage as types, so that a delay cannot be passed as a count of clocks. A
// bare number does not convert: the constructors are explicit, and none of the types is an
// aggregate. A number with a fraction does not compile, because the fraction would be lost.
#pragma once

#include <compare>
#include <concepts>
#include <cstdint>
#include <limits>
#include <utility>

#include "biss/base/language.hpp"

namespace biss {

/// Has no definition: a constant that calls it does not compile.
void number_does_not_fit();

/// A parameter that accepts whole numbers only: an argument with a fraction does not compile. If
/// Number is unsigned, a signed argument has to be a constant in its range. Converts implicitly, on
/// purpose. \pre an unsigned argument that is wider than Number fits.
template <class Number>
struct Whole {
  Number value;

  constexpr Whole(Number number) : value(number) {}
  consteval Whole(std::signed_integral auto number) requires std::unsigned_integral<Number>
      : value(static_cast<Number>(number)) {
    if (!std::in_range<Number>(number)) number_does_not_fit();
  }
  Whole(std::floating_point auto) = delete;
};

/// A point in time or a duration in picoseconds, signed. The range is 106 days in both directions.
/// An operation or a conversion whose result does not fit is a programming error. Times do not
/// saturate, because they are added and subtracted.
struct Picoseconds {
  std::int64_t count = 0;

  constexpr Picoseconds() = default;
  constexpr explicit Picoseconds(std::int64_t n) : count(n) {}
  explicit Picoseconds(std::floating_point auto) = delete;

  constexpr auto operator<=>(const Picoseconds&) const = default;
  constexpr Picoseconds operator-() const { return Picoseconds{-count}; }
  constexpr Picoseconds& operator+=(Picoseconds other) {
    count += other.count;
    return *this;
  }
  constexpr Picoseconds& operator-=(Picoseconds other) {
    count -= other.count;
    return *this;
  }
};

constexpr Picoseconds operator+(Picoseconds a, Picoseconds b) {
  return Picoseconds{a.count + b.count};
}
constexpr Picoseconds operator-(Picoseconds a, Picoseconds b) {
  return Picoseconds{a.count - b.count};
}
constexpr Picoseconds operator*(Picoseconds a, Whole<std::int64_t> n) {
  return Picoseconds{a.count * n.value};
}
constexpr Picoseconds operator*(Whole<std::int64_t> n, Picoseconds a) { return a * n; }
/// Rounded towards zero. \pre n is not 0.
constexpr Picoseconds operator/(Picoseconds a, Whole<std::int64_t> n) {
  return Picoseconds{a.count / n.value};
}

constexpr Picoseconds picoseconds(Whole<std::int64_t> n) { return Picoseconds{n.value}; }
constexpr Picoseconds nanoseconds(Whole<std::int64_t> n) { return Picoseconds{n.value * 1'000}; }
constexpr Picoseconds microseconds(Whole<std::int64_t> n) {
  return Picoseconds{n.value * 1'000'000};
}
constexpr Picoseconds milliseconds(Whole<std::int64_t> n) {
  return Picoseconds{n.value * 1'000'000'000};
}

/// A rate in hertz: a clock frequency or cycles a second.
struct Hertz {
  std::uint32_t count = 0;

  constexpr Hertz() = default;
  constexpr explicit Hertz(std::uint32_t n) : count(n) {}
  explicit Hertz(std::floating_point auto) = delete;

  constexpr auto operator<=>(const Hertz&) const = default;
};

/// The highest rate, 4.29 GHz. Conversions return it for a higher rate: a comparison with the limits
/// of a device, which are all lower, has the same result.
inline constexpr Hertz hertz_max{std::numeric_limits<std::uint32_t>::max()};

/// \pre n is at most 4 294 967 295.
constexpr Hertz hertz(Whole<std::uint32_t> n) { return Hertz{n.value}; }
/// hertz_max above 4 294 967 kHz.
constexpr Hertz kilohertz(Whole<std::uint32_t> n) {
  return n.value <= hertz_max.count / 1'000U ? Hertz{n.value * 1'000U} : hertz_max;
}
/// hertz_max above 4294 MHz.
constexpr Hertz megahertz(Whole<std::uint32_t> n) {
  return n.value <= hertz_max.count / 1'000'000U ? Hertz{n.value * 1'000'000U} : hertz_max;
}

inline constexpr std::int64_t picoseconds_per_second = 1'000'000'000'000;

/// Period of a rate, rounded to the nearest picosecond. A rate of 0 Hz has the period 0.
constexpr Picoseconds period_of(Hertz rate) {
  if (rate.count == 0) return {};
  return Picoseconds{(picoseconds_per_second + rate.count / 2) / rate.count};
}

/// Rate of a period, rounded to the nearest hertz; 0 Hz for a period that is not positive or above
/// 2 s, hertz_max for a period that is shorter than its period.
constexpr Hertz rate_of(Picoseconds period) {
  if (period.count <= 0) return {};
  const std::int64_t rate = (picoseconds_per_second + period.count / 2) / period.count;
  return rate > hertz_max.count ? hertz_max : Hertz{static_cast<std::uint32_t>(rate)};
}

/// Whole clocks needed to cover a duration, rounded up; 0 for a duration that is not positive.
/// \pre period is positive.
constexpr std::int64_t clocks_to_cover(Picoseconds duration, Picoseconds period) {
  if (duration.count <= 0) return 0;
  return (duration.count - 1) / period.count + 1;
}

/// A length in millimetres: a cable. A number of metres beyond 9 223 372 036 854 775 in either
/// direction is a programming error.
struct Millimetres {
  std::int64_t count = 0;

  constexpr Millimetres() = default;
  constexpr explicit Millimetres(std::int64_t n) : count(n) {}
  explicit Millimetres(std::floating_point auto) = delete;

  constexpr auto operator<=>(const Millimetres&) const = default;
};

constexpr Millimetres millimetres(Whole<std::int64_t> n) { return Millimetres{n.value}; }
constexpr Millimetres metres(Whole<std::int64_t> n) { return Millimetres{n.value * 1'000}; }

/// A voltage in nanovolts, signed. The range is 9 223 372 036 V in both directions; an operation or a
/// conversion whose result does not fit is a programming error.
struct Nanovolts {
  std::int64_t count = 0;

  constexpr Nanovolts() = default;
  constexpr explicit Nanovolts(std::int64_t n) : count(n) {}
  explicit Nanovolts(std::floating_point auto) = delete;

  constexpr auto operator<=>(const Nanovolts&) const = default;
};

constexpr Nanovolts millivolts(Whole<std::int64_t> n) { return Nanovolts{n.value * 1'000'000}; }

}  // namespace biss
