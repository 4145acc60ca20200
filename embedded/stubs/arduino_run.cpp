// Runs the sketch of the Arduino package on a PC: five requests, each with a different line.
#include <Arduino.h>
#include <BissC.h>
#include <SPI.h>

#include <cstdlib>

#include "biss/frame/format_text.hpp"
#include "embedded/stubs/line.hpp"

void setup();
void loop();

namespace {

int transfers = 0;

}  // namespace

void SPIClass::beginTransaction(SPISettings settings) {
  const bool right =
      settings.clock == 1000000 && settings.order == MSBFIRST && settings.mode == SPI_MODE3;
  if (!right) std::abort();
}

void SPIClass::transfer(void* buffer, std::size_t count) {
  constexpr stubs::LineFault faults[] = {stubs::LineFault::none, stubs::LineFault::no_response,
                                         stubs::LineFault::crc, stubs::LineFault::none,
                                         stubs::LineFault::error_bit};
  const std::span bytes(static_cast<std::uint8_t*>(buffer), count);
  const auto number = static_cast<unsigned>(transfers++);
  stubs::receive(bytes, biss::frame_format("pos18,nE,nW,crc6"), 100000U + number, 12,
                 faults[number]);
}

void delay(unsigned long) {
  if (transfers == 5) std::exit(0);
}

int main() {
  setup();
  for (;;) loop();
}
