// The record of an encoder in a page of the nRF51's flash. Registers: nRF51 Series Reference Manual,
// "Non-Volatile Memory Controller (NVMC)".
#pragma once

#include <cstddef>
#include <cstdint>

#include "biss/configure/encoder_record.hpp"
#include "firmware/boards/cortex_m.hpp"

namespace boards {

/// `page` is the first address of a page that has nothing else.
template <std::uint32_t page>
struct Nrf51FlashRecord {
  static_assert(page % 1024 == 0);
  static_assert(sizeof(biss::RecordBytes) % 4 == 0);

  static void load(biss::RecordBytes& bytes) {
    for (std::uint32_t i = 0; i < bytes.size(); ++i) {
      bytes[i] = static_cast<std::uint8_t>(at(page + i / 4 * 4) >> 8 * (i % 4));
    }
  }

  /// Takes up to 25 ms, in which the processor stops.
  static void store(const biss::RecordBytes& bytes) {
    constexpr std::uint32_t config = nvmc + 0x504;
    at(config) = 2;  // EEN: pages may be erased
    at(nvmc + 0x508) = page;
    wait();
    at(config) = 1;  // WEN: words may be written
    for (std::uint32_t i = 0; i < bytes.size(); i += 4) {
      const std::uint32_t low = bytes[i] | std::uint32_t{bytes[i + 1]} << 8;
      const std::uint32_t high = bytes[i + 2] | std::uint32_t{bytes[i + 3]} << 8;
      at(page + i) = low | high << 16;
      wait();
    }
    at(config) = 0;
  }

 private:
  static constexpr std::uint32_t nvmc = 0x4001'E000;

  static void wait() {
    while (at(nvmc + 0x400) == 0) {
    }
  }
};

}  // namespace boards
