// Copies of a safety monitor, which itself cannot be copied: for tests and measurements only.
#pragma once

#include <cstddef>
#include <new>

namespace biss::test {

/// The bytes of a monitor.
template <class Monitor>
class MonitorBytes {
 public:
  explicit MonitorBytes(const Monitor& monitor) {
    __builtin_memcpy(bytes_, static_cast<const void*>(&monitor), sizeof bytes_);
  }
  void put_into(Monitor& monitor) const {
    __builtin_memcpy(static_cast<void*>(&monitor), bytes_, sizeof bytes_);
  }

  static constexpr std::size_t size_bits = sizeof(Monitor) * 8U;

  void flip(std::size_t bit) {
    bytes_[bit / 8U] = static_cast<unsigned char>(bytes_[bit / 8U] ^ (1U << (bit % 8U)));
  }
  Monitor& monitor() { return *std::launder(reinterpret_cast<Monitor*>(bytes_)); }

 private:
  alignas(Monitor) unsigned char bytes_[sizeof(Monitor)];
};

}  // namespace biss::test
