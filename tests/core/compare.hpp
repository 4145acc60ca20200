// Comparison and output of values, identical on host and target.
#pragma once

#include <concepts>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace biss::test {

/// A value in the message of a failure: sign and magnitude, or no value.
struct Shown {
  bool is_number = false;
  bool negative = false;
  std::uint64_t magnitude = 0;
};

template <class T>
constexpr Shown show(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return show(static_cast<std::underlying_type_t<T>>(value));
  } else if constexpr (std::integral<T>) {
    const auto wide = static_cast<std::uint64_t>(value);
    if constexpr (std::signed_integral<T>) {
      if (value < 0) return {true, true, ~wide + 1U};
    }
    return {true, false, wide};
  } else {
    return {};
  }
}

template <class A, class B>
constexpr bool equal(const A& a, const B& b) {
  if constexpr (std::integral<A> && std::integral<B>) {
    return std::cmp_equal(+a, +b);
  } else {
    return a == b;
  }
}

}  // namespace biss::test
