// Parts of every Cortex-M: registers, the interrupt mask, the timer of the control cycle.
#pragma once

#include <cstdint>

#include "biss/configure/encoder_record.hpp"

namespace boards {

/// The register at this address.
inline volatile std::uint32_t& at(std::uint32_t address) {
  return *reinterpret_cast<volatile std::uint32_t*>(address);
}

/// Waits until all of these bits of a register are set.
inline void wait_for(std::uint32_t address, std::uint32_t bits) {
  while ((at(address) & bits) != bits) {
  }
}

/// The address of an object, as the DMA takes it.
inline std::uint32_t address_of(const volatile void* object) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(object));
}

/// Keeps the compiler from moving accesses to a DMA's buffer across accesses to its registers.
inline void buffer_barrier() { asm volatile("" ::: "memory"); }

/// Masks all interrupts while it lives, and is a barrier for the compiler.
class InterruptMask {
 public:
  InterruptMask() { asm volatile("cpsid i" ::: "memory"); }
  ~InterruptMask() { asm volatile("cpsie i" ::: "memory"); }
  InterruptMask(const InterruptMask&) = delete;
  InterruptMask& operator=(const InterruptMask&) = delete;
};

/// Waits for at least this number of processor clocks: one round takes three or more.
inline void wait_clocks(std::uint32_t clocks) {
  for (; clocks > 2; clocks -= 3) asm volatile("");
}

inline void wait_for_interrupt() { asm volatile("wfi" ::: "memory"); }

/// Enables an external interrupt (NVIC_ISER).
inline void enable_interrupt(unsigned number) {
  at(0xE000'E100U + number / 32U * 4U) = 1U << number % 32U;
}

/// The record in RAM that a reset does not clear, in place of flash: it is lost without power.
extern biss::RecordBytes kept_record;
struct KeptRecord {
  void load(biss::RecordBytes& bytes) const { bytes = kept_record; }
  void store(const biss::RecordBytes& bytes) { kept_record = bytes; }
};

/// SysTick interrupts every `clocks` clocks of the processor.
inline void start_cycle_timer(std::uint32_t clocks) {
  at(0xE000'E014U) = clocks - 1U;
  at(0xE000'E018U) = 0;
  at(0xE000'E010U) = 7;  // processor clock, interrupt, on
}

inline void stop_cycle_timer() { at(0xE000'E010U) = 0; }

}  // namespace boards
