#include "capi/handle_table.hpp"

#include <array>
#include <atomic>
#include <cstddef>

namespace biss::capi {

namespace {

// A place for one handle; 0: free. Places are never freed, so that no reader needs a lock.
struct Place {
  std::atomic<HandleAddress> handle{};
  std::atomic<HandleKind> kind{};
  Place* next = nullptr;
};

constexpr unsigned bucket_bits = 10;
constinit std::array<std::atomic<Place*>, std::size_t{1} << bucket_bits> buckets{};

std::atomic<Place*>& bucket_of(HandleAddress address) {
  return buckets[static_cast<std::size_t>((std::uint64_t{address} * 0x9E3779B97F4A7C15U) >>
                                          (64U - bucket_bits))];
}

Place* place_of(HandleAddress address) {
  for (Place* place = bucket_of(address).load(std::memory_order_acquire); place != nullptr;
       place = place->next) {
    if (place->handle.load(std::memory_order_acquire) == address) return place;
  }
  return nullptr;
}

bool take_free_place(HandleAddress address, HandleKind kind) {
  for (Place* place = bucket_of(address).load(std::memory_order_acquire); place != nullptr;
       place = place->next) {
    HandleAddress empty = 0;
    if (!place->handle.compare_exchange_strong(empty, address)) continue;
    place->kind.store(kind, std::memory_order_release);
    return true;
  }
  return false;
}

}  // namespace

bool add_handle(HandleAddress address, HandleKind kind) {
  if (take_free_place(address, kind)) return true;
  void* memory = std::malloc(sizeof(Place));
  if (memory == nullptr) return false;
  auto* place = new (memory) Place();
  place->handle.store(address, std::memory_order_relaxed);
  place->kind.store(kind, std::memory_order_relaxed);
  std::atomic<Place*>& bucket = bucket_of(address);
  place->next = bucket.load(std::memory_order_relaxed);
  while (!bucket.compare_exchange_weak(place->next, place, std::memory_order_release,
                                       std::memory_order_relaxed)) {
  }
  return true;
}

void remove_handle(HandleAddress address) {
  Place* place = address == 0 ? nullptr : place_of(address);
  if (place == nullptr) return;
  place->kind.store(nullptr, std::memory_order_relaxed);
  place->handle.store(0, std::memory_order_release);
}

bool is_open(HandleAddress address, HandleKind kind) {
  if (address == 0) return false;
  const Place* place = place_of(address);
  return place != nullptr && place->kind.load(std::memory_order_acquire) == kind;
}

}  // namespace biss::capi
