// Runs a sketch of the Arduino package on a PC: five requests, each with a different line. The
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

int transfers = 0;

void answer(std::span<std::uint8_t> bytes, std::uint16_t ack_clocks) {
  constexpr stubs::LineFault faults[] = {stubs::LineFault::none, stubs::LineFault::no_response,
                                         stubs::LineFault::crc, stubs::LineFault::none,
                                         stubs::LineFault::error_bit};
  const auto number = static_cast<unsigned>(transfers++);
  stubs::receive(bytes, biss::frame_format("pos18,nE,nW,crc6"), 100000U + number, ack_clocks,
                 faults[number]);
}

// The line of pins, and the clocks of MA so far. The line has a leading one more than the sketch
// samples.
std::array<std::uint8_t, 8> line{};
unsigned clocks = 0;
unsigned long quarters = 0;  // of a microsecond

}  // namespace

unsigned long micros() { return quarters++ / 4; }

void digitalWrite(int, int level) {
  if (level == HIGH) return;
  if (clocks++ == 0) answer(line, 4);
  if (transfers == 4 && clocks == 20) quarters += 80;
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

void delay(unsigned long) {
  if (transfers == 5) std::exit(0);
  clocks = 0;
}

int main() {
  setup();
  for (;;) loop();
}
