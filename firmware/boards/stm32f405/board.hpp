// STM32F405 (also F407, F415, F417): SPI1 with two streams of DMA2, registers only.
//
//   PA5  SPI1_SCK   to the RS-422 driver of MA
//   PA6  SPI1_MISO  from the RS-422 receiver of SLO
//   PA9  USART1_TX  text, 115200 baud
//
// Section numbers refer to ST's reference manual RM0090. clock_setup() runs the processor at 160
// MHz and APB2 at 80 MHz, from the internal oscillator of 16 MHz. A slow processor would answer CDM
// after the encoder's timeout.
#pragma once

#include <cstdint>
#include <span>

#include "biss/base/units.hpp"
#include "firmware/boards/cortex_m.hpp"

namespace boards {

namespace stm32f405 {

inline constexpr std::uint32_t rcc = 0x4002'3800U;     // 7.3
inline constexpr std::uint32_t flash = 0x4002'3C00U;   // 3.9
inline constexpr std::uint32_t gpioa = 0x4002'0000U;   // 8.4
inline constexpr std::uint32_t dma2 = 0x4002'6400U;    // 10.5
inline constexpr std::uint32_t usart1 = 0x4001'1000U;  // 30.6
inline constexpr std::uint32_t spi1 = 0x4001'3000U;    // 28.5

inline constexpr std::uint32_t spi_data = spi1 + 0x0CU;  // SPI_DR
inline constexpr unsigned dma_interrupt = 56;            // DMA2_Stream0

/// Streams of SPI1, both on channel 3 (10.3.3): 0 receives, 3 transmits.
inline constexpr std::uint32_t stream(unsigned number) { return dma2 + 0x10U + 0x18U * number; }
inline constexpr std::uint32_t number_of_data = 0x04;
inline constexpr std::uint32_t peripheral_address = 0x08;
inline constexpr std::uint32_t memory_address = 0x0C;
inline constexpr std::uint32_t channel_3 = 3U << 25U;
inline constexpr std::uint32_t very_high_priority = 3U << 16U;
inline constexpr std::uint32_t enabled = 1U << 0U;
// CR: EN, MINC, TCIE and TEIE. The priority makes the receiver win, so that nothing is lost.
inline constexpr std::uint32_t receive_setup =
    channel_3 | very_high_priority | 1U << 10U | 1U << 4U | 1U << 2U;
// CR: from memory to the peripheral; the same byte again and again.
inline constexpr std::uint32_t transmit_setup = channel_3 | 1U << 6U;
// LISR, LIFCR: all flags of streams 0 and 3; the transfer error of stream 0.
inline constexpr std::uint32_t all_flags = 0x3DU | 0x3DU << 22U;
inline constexpr std::uint32_t transfer_error = 1U << 3U;

inline void set_field(std::uint32_t address, unsigned shift, std::uint32_t mask,
                      std::uint32_t value) {
  at(address) = (at(address) & ~(mask << shift)) | value << shift;
}

inline void clock_setup() {
  at(flash) = 5U | 1U << 8U | 1U << 9U | 1U << 10U;  // ACR: 5 wait states, prefetch, caches
  at(rcc + 0x08U) = 5U << 10U | 4U << 13U;           // CFGR: APB1 / 4, APB2 / 2
  at(rcc + 0x04U) = 8U | 160U << 6U | 7U << 24U;     // PLLCFGR: HSI / 8 × 160 / 2
  at(rcc) = at(rcc) | 1U << 24U;                     // CR: PLLON
  wait_for(rcc, 1U << 25U);                          // PLLRDY
  at(rcc + 0x08U) = at(rcc + 0x08U) | 2U;            // CFGR: SW, the PLL
  wait_for(rcc + 0x08U, 2U << 2U);                   // SWS
}

}  // namespace stm32f405

/// Implements StartPort.
class Stm32f405 : public KeptRecord {
 public:
  static constexpr std::uint32_t clocks_per_microsecond = 160;
  static constexpr unsigned sck = 5;
  static constexpr unsigned miso = 6;
  static constexpr unsigned tx = 9;

  /// Call it first.
  void setup() {
    using namespace stm32f405;
#ifndef BISS_EMULATED  // the registers of clocks read as 0 in QEMU
    clock_setup();
#endif
    at(rcc + 0x30U) = at(rcc + 0x30U) | 1U << 0U | 1U << 22U;  // AHB1ENR: GPIOA, DMA2
    at(rcc + 0x44U) = at(rcc + 0x44U) | 1U << 4U | 1U << 12U;  // APB2ENR: USART1, SPI1
    setup_uart();
    setup_spi();
    setup_dma();
  }

  /// Implements SpiDma.
  bool start(std::span<std::uint8_t> receive) {
    using namespace stm32f405;
    if (running_) return false;
    running_ = true;
    buffer_barrier();
    // MA is high from here on, for half a period at least.
    release_ma();
    wait_clocks(2U << rate_);
    at(dma2 + 0x08U) = all_flags;  // LIFCR
    at(stream(0) + memory_address) = address_of(receive.data());
    at(stream(0) + number_of_data) = receive.size();
    at(stream(3) + number_of_data) = receive.size();
    at(stream(0)) = receive_setup | enabled;
    at(stream(3)) = transmit_setup | enabled;
    return true;
  }

  /// APB2 at 80 MHz, divided by 16, 32 … 256: up to 5 MHz, for 20 m of cable.
  biss::Picoseconds set_clock(biss::Hertz most) {
    rate_ = 3;
    while (80'000'000U >> (rate_ + 1U) > most.count) ++rate_;
    stm32f405::set_field(stm32f405::spi1, 3, 7, rate_);  // CR1: BR
    return biss::picoseconds(12'500) * (std::int64_t{2} << rate_);
  }

  /// SCK becomes an output that is low (BSRR, MODER).
  void hold_ma_low() {
    using namespace stm32f405;
    at(gpioa + 0x18U) = 1U << (sck + 16U);
    set_field(gpioa, 2U * sck, 3, 1);
  }

  /// Call it first in the interrupt. \return false: the DMA failed, the buffer is not filled
  bool acknowledge() {
    using namespace stm32f405;
    const bool good = (at(dma2) & transfer_error) == 0;  // LISR
    at(dma2 + 0x08U) = all_flags;
    buffer_barrier();
    running_ = false;
    return good;
  }

  static void put(char letter) {
    while ((at(stm32f405::usart1) & 1U << 7U) == 0) {  // SR: TXE
    }
    at(stm32f405::usart1 + 0x04U) = static_cast<std::uint8_t>(letter);
  }

 private:
  // The SPI is idle high. The pin is, too, before it becomes its output.
  void release_ma() {
    using namespace stm32f405;
    at(gpioa + 0x18U) = 1U << sck;
    set_field(gpioa, 2U * sck, 3, 2);
  }

  void setup_uart() {
    using namespace stm32f405;
    set_field(gpioa + 0x24U, 4U * (tx - 8U), 15, 7);  // AFRH: AF7
    set_field(gpioa, 2U * tx, 3, 2);
    at(usart1 + 0x08U) = 694;                   // BRR: 80 MHz / 115200
    at(usart1 + 0x0CU) = 1U << 13U | 1U << 3U;  // CR1: UE, TE
  }

  void setup_spi() {
    using namespace stm32f405;
    // CR1: CPHA, CPOL, master, clock / 16, on, SSI and SSM: chip select is not used.
    at(spi1) = 1U << 0U | 1U << 1U | 1U << 2U | 3U << 3U | 1U << 6U | 1U << 8U | 1U << 9U;
    set_field(gpioa + 0x20U, 4U * sck, 15, 5);  // AFRL: AF5
    set_field(gpioa + 0x20U, 4U * miso, 15, 5);
    set_field(gpioa + 0x08U, 2U * sck, 3, 2);  // OSPEEDR: fast
    set_field(gpioa + 0x0CU, 2U * sck, 3, 1);  // PUPDR: pull-up
    set_field(gpioa + 0x0CU, 2U * miso, 3, 1);
    set_field(gpioa, 2U * miso, 3, 2);
    release_ma();
  }

  void setup_dma() {
    using namespace stm32f405;
    static constexpr std::uint8_t zero = 0;  // the encoder receives no data
    at(stream(0) + peripheral_address) = spi_data;
    at(stream(3) + peripheral_address) = spi_data;
    at(stream(3) + memory_address) = address_of(&zero);
    at(spi1 + 0x04U) = 3;  // CR2: RXDMAEN, TXDMAEN
    enable_interrupt(dma_interrupt);
  }

  bool running_ = false;
  unsigned rate_ = 3;
};

using Board = Stm32f405;

}  // namespace boards
