// Output and exit through the debugger (Arm semihosting), which qemu-system-arm answers.
#pragma once

#include <cstdint>

namespace firmware {

/// Writes a C string to the debugger's console.
void write(const char* text);
/// Writes a number in decimal, or in hexadecimal with 0x before it.
void write_decimal(std::uint64_t value);
void write_hex(std::uint64_t value);
/// Ends the emulation with the given exit status.
[[noreturn]] void exit(int status);

}  // namespace firmware
