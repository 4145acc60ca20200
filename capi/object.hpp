// The C++ object in the memory of a C object, and the mark by which every call recognises it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>

#include "capi/biss_c.h"

namespace biss::capi {

template <class Object>
inline constexpr char kind{};

/// Depends on the kind of the object and on its address; never 0.
template <class Object>
std::uintptr_t mark_of(const Object* object) {
  return reinterpret_cast<std::uintptr_t>(object) ^ reinterpret_cast<std::uintptr_t>(&kind<Object>);
}

template <class Object>
bool is_open(const Object* object) {
  return object != nullptr && object->mark == mark_of(object);
}

/// The C++ object. \pre is_open(), and made as a `Thing`
template <class Thing, class Object>
auto& thing(Object* object) {
  using Here = std::conditional_t<std::is_const_v<Object>, const Thing, Thing>;
  return *std::launder(reinterpret_cast<Here*>(object->memory));
}

/// The first step of an init. Without init, or after one that failed, the object is not open.
template <class Object, class... Pointers>
biss_status begin_init(Object* object, const Pointers*... needed) {
  if (object == nullptr) return BISS_NULL_ARGUMENT;
  object->mark = 0;
  return (... || (needed == nullptr)) ? BISS_NULL_ARGUMENT : BISS_OK;
}

/// The last step of an init.
template <class Thing, class Object, class... Arguments>
biss_status make(Object* object, const Arguments&... arguments) {
  static_assert(sizeof(Thing) <= sizeof(object->memory), "more memory in the header");
  static_assert(alignof(Thing) <= alignof(std::uint64_t));
  static_assert(std::is_trivially_destructible_v<Thing>, "nothing has to be freed");
  new (object->memory) Thing(arguments...);
  object->mark = mark_of(object);
  return BISS_OK;
}

/// Why a function cannot use this object: a pointer that it needs is null, or it is not open.
template <class Object, class... Pointers>
biss_status check_call(const Object* object, const Pointers*... needed) {
  if (object == nullptr || (... || (needed == nullptr))) return BISS_NULL_ARGUMENT;
  return is_open(object) ? BISS_OK : BISS_BAD_HANDLE;
}

/// Calls `call` with the C++ object, unless check_call() refuses.
template <class Thing, class Object, class Call>
biss_status with(Object* object, const Call& call) {
  const biss_status wrong = check_call(object);
  if (wrong == BISS_OK) call(thing<Thing>(object));
  return wrong;
}

/// For check_call(): `bytes`, but a valid pointer if there are no bytes.
inline const void* given(const std::uint8_t* bytes, std::size_t count) {
  static constexpr char none{};
  return count == 0 ? &none : static_cast<const void*>(bytes);
}

}  // namespace biss::capi
