// The handles that are open, by address: a closed or foreign one is found without reading from it.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <new>

namespace biss::capi {

enum class HandleKind : std::uint8_t {
  none,
  slave,
  master,
  format,
  spi,
  control,
  eds,
  safety,
  line,
  simulation,
  vcd,
};

/// A handle is only compared, never read: its address is enough.
using HandleAddress = std::uintptr_t;

template <class Handle>
HandleAddress address_of(const Handle* handle) {
  return reinterpret_cast<HandleAddress>(handle);
}

/// False: no memory. \pre the address is not 0 and not open
bool add_handle(HandleAddress address, HandleKind kind);
/// Nothing where it is not open.
void remove_handle(HandleAddress address);
/// Whether this handle is open and of this kind. Other threads may open and close others meanwhile.
bool is_open(HandleAddress address, HandleKind kind);

template <class Handle>
bool is_open(const Handle* handle) {
  return is_open(address_of(handle), Handle::kind);
}

/// On the C heap, so that C programs link without the C++ library. Null: no memory. Each type of
/// handle has a `kind`.
template <class Handle, class... Arguments>
Handle* make_handle(const Arguments&... arguments) {
  struct Memory {
    void* at;
    ~Memory() { std::free(at); }
  };
  Memory memory{std::malloc(sizeof(Handle))};
  if (memory.at == nullptr) return nullptr;
  auto* handle = new (memory.at) Handle(arguments...);
  if (!add_handle(address_of(handle), Handle::kind)) {
    handle->~Handle();
    return nullptr;
  }
  memory.at = nullptr;
  return handle;
}

/// Nothing where it is not open.
template <class Handle>
void destroy_handle(Handle* handle) {
  if (!is_open(handle)) return;
  remove_handle(address_of(handle));
  handle->~Handle();
  std::free(handle);
}

}  // namespace biss::capi
