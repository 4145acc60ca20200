// Vector table, start-up from reset to firmware_main(), and the message of a fault.
#include "firmware/platform/startup.hpp"

#include "firmware/platform/console.hpp"

extern "C" {
extern std::uint32_t data_load[];
extern std::uint32_t data_begin[];
extern std::uint32_t data_end[];
extern std::uint32_t bss_begin[];
extern std::uint32_t bss_end[];

[[noreturn]] void reset_handler();
[[noreturn]] void fault_handler();
[[noreturn]] void report_fault(const std::uint32_t* frame);
void unexpected_handler();

[[gnu::weak, gnu::alias("unexpected_handler")]] void systick_handler();
[[gnu::weak, gnu::alias("unexpected_handler")]] void dma_complete_handler();
}

namespace {

constexpr int status_fault = 3;

union Vector {
  const std::uint32_t* stack;
  void (*handler)();
};

// The external interrupt of the DMA channel.
#ifndef BISS_DMA_INTERRUPT
#define BISS_DMA_INTERRUPT 0
#endif

struct VectorTable {
  Vector core[16];
  Vector external[BISS_DMA_INTERRUPT + 1];
};

// Order: Arm v6-M and v7-M architecture reference manuals, "The vector table".
constexpr VectorTable vector_table() {
  VectorTable table{};
  for (Vector& vector : table.core) vector.handler = unexpected_handler;
  for (Vector& vector : table.external) vector.handler = unexpected_handler;
  table.core[0].stack = stack_top;
  table.core[1].handler = reset_handler;
  // HardFault, MemManage, BusFault, UsageFault
  for (int number = 3; number <= 6; ++number) table.core[number].handler = fault_handler;
  table.core[15].handler = systick_handler;
  table.external[BISS_DMA_INTERRUPT].handler = dma_complete_handler;
  return table;
}

}  // namespace

extern "C" {

[[gnu::used, gnu::section(".vectors")]] constinit const VectorTable vectors = vector_table();

void reset_handler() {
  const std::uint32_t* from = data_load;
  for (std::uint32_t* to = data_begin; to != data_end;) *to++ = *from++;
  for (std::uint32_t* to = bss_begin; to != bss_end;) *to++ = 0;
  firmware::exit(firmware_main());
}

// An overflowed stack cannot be used to report the fault: take the frame's address and start a new
// stack.
[[gnu::naked]] void fault_handler() {
  asm volatile(
      "mrs r0, msp\n"
      "ldr r1, =stack_top\n"
      "mov sp, r1\n"
      "ldr r1, =report_fault\n"
      "bx r1\n"
      ".ltorg\n");
}

void report_fault(const std::uint32_t* frame) {
  firmware::write("HARD FAULT");
  if (frame < stack_bottom) {
    firmware::write(": stack overflow");
  } else {
    firmware::print(" at pc ", firmware::Hex{frame[6]}, ", lr ", firmware::Hex{frame[5]});
  }
  firmware::write("\n");
  firmware::exit(status_fault);
}

void unexpected_handler() {
  std::uint32_t number = 0;
  asm volatile("mrs %0, ipsr" : "=r"(number));
  firmware::print("UNEXPECTED EXCEPTION ", number, "\n");
  firmware::exit(status_fault);
}

}  // extern "C"
