// Result: a value, or the one cause why there is no value. No exceptions, no error codes among the
// values.
#pragma once

#include <type_traits>
#include <utility>

#include "biss/base/language.hpp"

namespace biss {

/// Wraps a cause for a Result: `return failure(FrameError::crc);`
template <class E>
struct Failure {
  E error;
};

template <class E>
constexpr Failure<E> failure(E error) {
  return {error};
}

namespace result_detail {

struct Nothing {};

// Not constexpr: the compiler prints this name if a constant expression reads the value of a failed
// result.
inline void this_result_holds_an_error_and_no_value() {}
inline void this_result_holds_a_value_and_no_error() {}

}  // namespace result_detail

/// Either a T or an E. Both are plain data, so a Result is too. Reading the wrong side is a
/// programming error, which stops the build while compiling: value() needs ok(), error() needs
/// !ok().
template <class T, class E>
class [[nodiscard]] Result {
  static_assert(std::is_trivially_destructible_v<T> && std::is_trivially_destructible_v<E>);

 public:
  constexpr Result(const T& value) : value_(value), no_error_(), ok_(true) {}
  constexpr Result(T&& value) : value_(std::move(value)), no_error_(), ok_(true) {}
  constexpr Result(Failure<E> failed) : no_value_(), error_(failed.error), ok_(false) {}

  /// Assigns the error without a copy of the value, so that a compiler can keep the value in
  /// registers.
  constexpr Result& operator=(Failure<E> failed) {
    if (std::is_constant_evaluated()) return *this = Result(failed);
    error_ = failed.error;
    ok_ = false;
    return *this;
  }

  constexpr bool ok() const { return ok_; }
  constexpr explicit operator bool() const { return ok_; }
  constexpr const T& value() const {
    needs_value();
    return value_;
  }
  constexpr T& value() {
    needs_value();
    return value_;
  }
  constexpr const T& operator*() const { return value(); }
  constexpr const T* operator->() const { return &value(); }
  constexpr const E& error() const {
    if (std::is_constant_evaluated() && ok_) {
      result_detail::this_result_holds_a_value_and_no_error();
    }
    return error_;
  }

 private:
  constexpr void needs_value() const {
    if (std::is_constant_evaluated() && !ok_) {
      result_detail::this_result_holds_an_error_and_no_value();
    }
  }

  // Two unions, because a compiler keeps in registers only members that share no memory.
  union {
    T value_;
    result_detail::Nothing no_value_;
  };
  union {
    E error_;
    result_detail::Nothing no_error_;
  };
  bool ok_;
};

}  // namespace biss
