// Parts that the C++20 library of emscripten 3.1.6 lacks. Included before every source.
#pragma once

#include <charconv>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <version>

namespace biss::wasm {

/// Reads a decimal number from the front of a text as std::from_chars() does, except that infinity
/// and NaN are invalid_argument. Sets `value` only if there is no error.
std::from_chars_result from_chars(const char* begin, const char* end, double& value);
/// Writes the shortest text from which from_chars() reads `value`, as std::to_chars() does.
std::to_chars_result to_chars(char* begin, char* end, double value);

}  // namespace biss::wasm

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
using biss::wasm::from_chars;
using biss::wasm::to_chars;
#endif

}  // namespace std
