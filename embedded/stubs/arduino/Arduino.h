// The parts of Arduino's core that the example uses, on a PC.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

// Arduino's cores define these.
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define abs(x) ((x) > 0 ? (x) : -(x))
#define round(x) ((x) >= 0 ? (long)((x) + 0.5) : (long)((x)-0.5))

using uint8_t = std::uint8_t;
using uint32_t = std::uint32_t;

struct SerialPort {
  void begin(unsigned long) {}
  void println(long value) { std::printf("%ld\n", value); }
  void println(const char* text) { std::printf("%s\n", text); }
};
inline SerialPort Serial;
void delay(unsigned long milliseconds);
unsigned long micros();
unsigned long millis();

enum { LOW = 0, HIGH = 1, INPUT = 0, OUTPUT = 1 };
inline void pinMode(int, int) {}
void digitalWrite(int pin, int level);
int digitalRead(int pin);
