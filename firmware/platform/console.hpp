// Text output and the end of an image. The emulated boards of the tests answer through the debugger
// (semihosting.cpp), the examples of firmware/boards through their serial port.
#pragma once

#include <cstdint>
#include <string_view>

namespace firmware {

/// Writes a C string.
void write(const char* text);
/// Writes a name of the core. All of them are literals, so they end with a zero.
inline void write(std::string_view name) { write(name.data()); }
/// Writes a number in decimal.
void write(std::uint64_t number);
/// Writes a number in hexadecimal, with 0x before it.
struct Hex {
  std::uint64_t number;
};
void write(Hex hex);

/// Writes texts and numbers, one after another.
template <class... Parts>
void print(const Parts&... parts) {
  (write(parts), ...);
}

/// Ends the image with the given exit status.
[[noreturn]] void exit(int status);

}  // namespace firmware
