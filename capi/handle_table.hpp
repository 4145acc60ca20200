// The handles that are open, by address: a closed or foreign one is found without reading from it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "capi/biss_c.h"

namespace biss::capi {

/// The type of a handle, as the address of a variable of its own; null: none.
using HandleKind = const void*;

template <class Handle>
inline constexpr char kind_variable{};
template <class Handle>
constexpr HandleKind kind_of = &kind_variable<Handle>;

/// A handle is only compared, never read: its address is enough.
using HandleAddress = std::uintptr_t;

template <class Handle>
HandleAddress address_of(const Handle* handle) {
  return reinterpret_cast<HandleAddress>(handle);
}

/// False: no memory. \pre the address is not 0 and not open
bool add_handle(HandleAddress address, HandleKind kind);
/// Does nothing if it is not open.
void remove_handle(HandleAddress address);
/// Whether this handle is open and of this kind. Other threads may open and close others meanwhile.
bool is_open(HandleAddress address, HandleKind kind);

template <class Handle>
bool is_open(const Handle* handle) {
  return is_open(address_of(handle), kind_of<Handle>);
}

/// On the C heap, so that C programs link without the C++ library. Null: no memory.
template <class Handle, class... Arguments>
Handle* make_handle(const Arguments&... arguments) {
  struct Memory {
    void* at;
    ~Memory() { std::free(at); }
  };
  Memory memory{std::malloc(sizeof(Handle))};
  if (memory.at == nullptr) return nullptr;
  auto* handle = new (memory.at) Handle(arguments...);
  if (!add_handle(address_of(handle), kind_of<Handle>)) {
    handle->~Handle();
    return nullptr;
  }
  memory.at = nullptr;
  return handle;
}

/// make_handle() as the last step of a function that opens one.
template <class Handle, class... Arguments>
biss_status open_handle(Handle*& handle, const Arguments&... arguments) {
  handle = make_handle<Handle>(arguments...);
  return handle == nullptr ? BISS_NO_MEMORY : BISS_OK;
}

/// Why a function cannot use this handle: a pointer that it needs is null, or the handle is not open.
template <class Handle, class... Pointers>
biss_status check_call(const Handle* handle, const Pointers*... needed) {
  if (handle == nullptr || (... || (needed == nullptr))) return BISS_NULL_ARGUMENT;
  return is_open(handle) ? BISS_OK : BISS_BAD_HANDLE;
}

/// For check_call(): `bytes`, but a valid pointer if there are no bytes.
inline const void* given(const std::uint8_t* bytes, std::size_t count) {
  static constexpr char none{};
  return count == 0 ? &none : static_cast<const void*>(bytes);
}

/// Does nothing if it is not open.
template <class Handle>
void destroy_handle(Handle* handle) {
  if (!is_open(handle)) return;
  remove_handle(address_of(handle));
  handle->~Handle();
  std::free(handle);
}

}  // namespace biss::capi
