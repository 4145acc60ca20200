// Parts that the C++20 library of emscripten 3.1.6 lacks. Included before every source.
#pragma once

#include <charconv>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <version>

namespace std {

#ifndef __cpp_lib_bit_cast
template <class To, class From>
requires(sizeof(To) == sizeof(From)) constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}
#endif

#ifndef __cpp_lib_smart_ptr_for_overwrite
template <class T>
requires is_unbounded_array_v<T> unique_ptr<T> make_unique_for_overwrite(size_t count) {
  return unique_ptr<T>(new remove_extent_t<T>[count]);
}
#endif

#ifndef __cpp_lib_to_chars
from_chars_result from_chars(const char* begin, const char* end, double& value);
to_chars_result to_chars(char* begin, char* end, double value);
#endif

}  // namespace std
