// The console through the debugger (Arm semihosting), which qemu-system-arm answers.
#include <array>

#include "firmware/platform/console.hpp"

namespace firmware {
namespace {

// Operation numbers and reason codes: Arm, "Semihosting for AArch32 and AArch64".
constexpr std::uint32_t sys_write0 = 0x04;
constexpr std::uint32_t sys_exit_extended = 0x20;
constexpr std::uint32_t application_exit = 0x20026;

void call(std::uint32_t operation, const void* argument) {
  register std::uint32_t r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
}

}  // namespace

void write(const char* text) { call(sys_write0, text); }

void exit(int status) {
  const std::array<std::uint32_t, 2> block{application_exit, static_cast<std::uint32_t>(status)};
  call(sys_exit_extended, block.data());
  for (;;) {
  }
}

}  // namespace firmware
