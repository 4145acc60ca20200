// Arduino's SPI library on a PC; the test supplies the received bytes.
#pragma once

#include <Arduino.h>

enum BitOrder { LSBFIRST = 0, MSBFIRST = 1 };
inline constexpr uint8_t SPI_MODE3 = 3;

struct SPISettings {
  SPISettings(uint32_t clock, BitOrder order, uint8_t mode)
      : clock(clock), order(order), mode(mode) {}
  uint32_t clock;
  BitOrder order;
  uint8_t mode;
};

class SPIClass {
 public:
  void begin() {}
  void beginTransaction(SPISettings settings);
  void transfer(void* buffer, std::size_t count);
  void endTransaction() {}
};
inline SPIClass SPI;
