// The functions that an image supplies, and the memory limits that the linker script supplies.
#pragma once

#include <cstdint>

/// The image's entry: called once with .data and .bss ready; its result is the exit status.
int firmware_main();

/// The SysTick exception. An image that uses the timer's interrupt defines it.
extern "C" void systick_handler();
/// The interrupt of the DMA channel: external interrupt 0 in the control-loop example, the
/// controller's own one on the boards of firmware/boards.
extern "C" void dma_complete_handler();

extern "C" {
// Set by the linker script; only their addresses mean anything.
extern std::uint32_t stack_bottom[];
extern std::uint32_t stack_top[];
}
