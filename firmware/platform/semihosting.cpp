#include "firmware/platform/semihosting.hpp"

#include <array>
#include <cstddef>

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

void write_number(std::uint64_t value, unsigned base) {
  std::array<char, 24> digits{};
  std::size_t at = digits.size() - 1;
  do {
    digits[--at] = "0123456789abcdef"[value % base];
    value /= base;
  } while (value != 0);
  write(&digits[at]);
}

}  // namespace

void write(const char* text) { call(sys_write0, text); }
void write_decimal(std::uint64_t value) { write_number(value, 10); }

void write_hex(std::uint64_t value) {
  write("0x");
  write_number(value, 16);
}

void exit(int status) {
  const std::array<std::uint32_t, 2> block{application_exit, static_cast<std::uint32_t>(status)};
  call(sys_exit_extended, block.data());
  for (;;) {
  }
}

}  // namespace firmware
