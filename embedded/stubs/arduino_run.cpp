// Runs a sketch of the Arduino package on a PC. micros() returns to 0 between two readings. The
// sketch with pins has an interrupt of 20 us in the fourth.
#include <Arduino.h>
#include <BissC.h>
#include <SPI.h>

#include <array>
#include <cstdlib>
#include <span>

#include "biss/frame/format_text.hpp"
#include "embedded/stubs/line.hpp"

void setup();
void loop();

namespace {

void answer(std::span<std::uint8_t> bytes, std::uint16_t ack_clocks) {
  stubs::receive(bytes, biss::frame_format("pos18,nE,nW,crc6"), 100000, ack_clocks);
}

// The line of pins, and the clocks of MA so far. The line has a leading one more than the sketch
// samples.
std::array<std::uint8_t, 8> line{};
unsigned clocks = 0;
// Since the start, in a quarter of a microsecond: micros() is 0 again after 350 ms.
std::uint64_t quarters = 4 * ((std::uint64_t{1} << 32U) - 350'000);

}  // namespace

unsigned long micros() { return static_cast<std::uint32_t>(quarters++ / 4); }
unsigned long millis() { return static_cast<std::uint32_t>(quarters / 4'000); }

void digitalWrite(int, int level) {
  if (level == HIGH) return;
  if (clocks == 0) {
    line.fill(0xFF);
    answer(line, 4);
  }
  ++clocks;
  if (stubs::transfers == 4 && clocks == 20) quarters += 80;
}

int digitalRead(int) { return line[clocks / 8] >> (7 - clocks % 8) & 1; }

void SPIClass::beginTransaction(SPISettings settings) {
  const bool right =
      settings.clock == 1000000 && settings.order == MSBFIRST && settings.mode == SPI_MODE3;
  if (!right) std::abort();
}

void SPIClass::transfer(void* buffer, std::size_t count) {
  answer(std::span(static_cast<std::uint8_t*>(buffer), count), 12);
}

void delay(unsigned long milliseconds) {
  if (stubs::done()) std::exit(0);
  clocks = 0;
  quarters += milliseconds * 4'000;
}

int main() {
  setup();
  for (;;) loop();
}
