// Text output and the end of an image. The emulated boards of the tests answer through the debugger
// (semihosting.cpp), the examples of firmware/boards through their serial port.
#pragma once

#include <cstdint>

namespace firmware {

/// Writes a C string.
void write(const char* text);
/// Writes a number in decimal, or in hexadecimal with 0x before it.
void write_decimal(std::uint64_t value);
void write_hex(std::uint64_t value);
/// Ends the image with the given exit status.
[[noreturn]] void exit(int status);

}  // namespace firmware
