// Raspberry Pi Pico (RP2040): SPI0 with two DMA channels, registers only.
//
//   GPIO 18  SPI0 SCK  to the RS-422 driver of MA
//   GPIO 16  SPI0 RX   from the RS-422 receiver of SLO
//   GPIO 0   UART0 TX  text, 115200 baud
//
// Section numbers refer to the RP2040 data sheet. clock_setup() runs clk_sys and clk_peri at 125
// MHz from a crystal of 12 MHz.
#pragma once

#include <cstdint>
#include <span>

#include "biss/base/units.hpp"
#include "firmware/boards/cortex_m.hpp"

namespace boards {

namespace rp2040 {

// Aliases of every register below 0x60000000 that set or clear bits (2.1.2).
inline void set_bits(std::uint32_t address, std::uint32_t bits) { at(address + 0x2000U) = bits; }
inline void clear_bits(std::uint32_t address, std::uint32_t bits) { at(address + 0x3000U) = bits; }

inline constexpr std::uint32_t clocks = 0x4000'8000U;      // 2.15.7
inline constexpr std::uint32_t resets = 0x4000'C000U;      // 2.14.3
inline constexpr std::uint32_t io_bank0 = 0x4001'4000U;    // 2.19.6.1
inline constexpr std::uint32_t pads_bank0 = 0x4001'C000U;  // 2.19.6.3
inline constexpr std::uint32_t xosc = 0x4002'4000U;        // 2.16.7
inline constexpr std::uint32_t pll_sys = 0x4002'8000U;     // 2.18.4
inline constexpr std::uint32_t uart0 = 0x4003'4000U;       // 4.2.8
inline constexpr std::uint32_t spi0 = 0x4003'C000U;        // 4.4.4
inline constexpr std::uint32_t dma = 0x5000'0000U;         // 2.5.7

inline constexpr std::uint32_t spi_data = spi0 + 0x08U;  // SSPDR
inline constexpr unsigned dma_interrupt = 11;            // DMA_IRQ_0

/// GPIOn_CTRL: FUNCSEL in bits 0…4, OUTOVER in bits 8 and 9.
inline constexpr std::uint32_t gpio_ctrl(unsigned pin) { return io_bank0 + 8U * pin + 4U; }
inline constexpr std::uint32_t function_spi = 1;
inline constexpr std::uint32_t function_uart = 2;
inline constexpr std::uint32_t drive_low = 2U << 8U;
/// Input enabled, 4 mA, Schmitt trigger, pull-up.
inline constexpr std::uint32_t pad_pull_up = 0x5A;

/// Channel registers (2.5.7): 0 receives, 1 transmits.
inline constexpr std::uint32_t channel(unsigned number) { return dma + 0x40U * number; }
inline constexpr std::uint32_t read_address = 0x00;
inline constexpr std::uint32_t write_address = 0x04;
inline constexpr std::uint32_t transfer_count = 0x08;
inline constexpr std::uint32_t control = 0x10;  // the alias that does not start the channel
inline constexpr std::uint32_t busy = 1U << 24U;
inline constexpr std::uint32_t bus_error = 1U << 31U;
inline constexpr std::uint32_t channel_setup(unsigned number, unsigned request,
                                             std::uint32_t options) {
  // EN, HIGH_PRIORITY; chained to itself: no chain.
  return 3U | number << 11U | request << 15U | options;
}

inline void clock_setup() {
  at(xosc) = 0xAA0;       // CTRL: 1 to 15 MHz
  at(xosc + 0x0CU) = 47;  // STARTUP: 1 ms
  set_bits(xosc, 0xFABU << 12U);
  wait_for(xosc + 0x04U, 1U << 31U);
  at(clocks + 0x30U) = 2;  // CLK_REF_CTRL: crystal
  wait_for(clocks + 0x38U, 1U << 2U);

  clear_bits(resets, 1U << 12U);
  wait_for(resets + 0x08U, 1U << 12U);
  at(pll_sys + 0x08U) = 125;                         // FBDIV_INT: 12 MHz × 125 = 1500 MHz
  clear_bits(pll_sys + 0x04U, 1U << 0U | 1U << 5U);  // PWR: PD, VCOPD
  wait_for(pll_sys, 1U << 31U);                      // CS: LOCK
  at(pll_sys + 0x0CU) = 6U << 16U | 2U << 12U;       // PRIM: / 6 / 2 = 125 MHz
  clear_bits(pll_sys + 0x04U, 1U << 3U);             // PWR: POSTDIVPD
  at(clocks + 0x3CU) = 1;                            // CLK_SYS_CTRL: PLL_SYS
  wait_for(clocks + 0x44U, 1U << 1U);
  at(clocks + 0x48U) = 1U << 11U;  // CLK_PERI_CTRL: on, from clk_sys
}

}  // namespace rp2040

/// Implements StartPort.
class Rp2040 : public KeptRecord {
 public:
  static constexpr std::uint32_t clocks_per_microsecond = 125;
  static constexpr unsigned sck = 18;
  static constexpr unsigned miso = 16;

  /// Call it first.
  void setup() {
    using namespace rp2040;
    clock_setup();
    // DMA, IO_BANK0, PADS_BANK0, SPI0, UART0.
    constexpr std::uint32_t used = 1U << 2U | 1U << 5U | 1U << 8U | 1U << 16U | 1U << 22U;
    clear_bits(resets, used);
    wait_for(resets + 0x08U, used);
    setup_uart();
    setup_spi();
    setup_dma();
  }

  /// Implements SpiDma.
  bool start(std::span<std::uint8_t> receive) {
    using namespace rp2040;
    if ((at(channel(0) + control) & busy) != 0) return false;
    buffer_barrier();
    // MA is high from here on, for half a period at least.
    at(gpio_ctrl(sck)) = function_spi;
    wait_clocks(divisor_ / 2U);
    at(channel(0) + write_address) = address_of(receive.data());
    at(channel(0) + transfer_count) = receive.size();
    at(channel(1) + transfer_count) = receive.size();
    at(dma + 0x430U) = 3;  // MULTI_CHAN_TRIGGER: both
    return true;
  }

  /// Up to 4 MHz, for 20 m of cable.
  biss::Picoseconds set_clock(biss::Hertz most) {
    constexpr std::uint32_t clock = clocks_per_microsecond * 1'000'000;
    divisor_ = 32;  // SSPCPSR: even, 2…254
    while (divisor_ * most.count < clock) divisor_ += 2;
    at(rp2040::spi0 + 0x10U) = divisor_;
    return biss::microseconds(1) * divisor_ / clocks_per_microsecond;
  }

  void hold_ma_low() { at(rp2040::gpio_ctrl(sck)) = rp2040::function_spi | rp2040::drive_low; }

  /// Call it first in the interrupt. \return false: the DMA failed, the buffer is not filled
  bool acknowledge() {
    using namespace rp2040;
    at(dma + 0x40CU) = 1;  // INTS0
    buffer_barrier();
    return (at(channel(0) + control) & bus_error) == 0;
  }

  static void put(char letter) {
    while ((at(rp2040::uart0 + 0x18U) & 1U << 5U) != 0) {  // UARTFR: TXFF
    }
    at(rp2040::uart0) = static_cast<std::uint8_t>(letter);
  }

 private:
  void setup_uart() {
    using namespace rp2040;
    at(gpio_ctrl(0)) = function_uart;
    at(uart0 + 0x24U) = 67;  // 125 MHz / 16 / 115200 = 67 + 52 / 64
    at(uart0 + 0x28U) = 52;
    at(uart0 + 0x2CU) = 3U << 5U | 1U << 4U;  // 8 bits, FIFO
    at(uart0 + 0x30U) = 1U << 8U | 1U << 0U;  // transmitter, UART
  }

  void setup_spi() {
    using namespace rp2040;
    set_clock(biss::common_clock_max);
    at(spi0) = 7U | 1U << 6U | 1U << 7U;           // SSPCR0: 8 bits, CPOL = 1, CPHA = 1
    at(spi0 + 0x24U) = 3;                          // SSPDMACR: both directions
    at(spi0 + 0x04U) = 1U << 1U;                   // SSPCR1: on, master
    at(pads_bank0 + 4U + 4U * sck) = pad_pull_up;  // MA is high before the pin is driven
    at(pads_bank0 + 4U + 4U * miso) = pad_pull_up;
    at(gpio_ctrl(miso)) = function_spi;
    at(gpio_ctrl(sck)) = function_spi;
  }

  void setup_dma() {
    using namespace rp2040;
    static constexpr std::uint8_t zero = 0;  // the encoder receives no data
    constexpr std::uint32_t increment_write = 1U << 5U;
    constexpr std::uint32_t quiet = 1U << 21U;  // no interrupt
    at(channel(0) + read_address) = spi_data;
    at(channel(0) + control) = channel_setup(0, 17, increment_write);  // DREQ_SPI0_RX
    at(channel(1) + read_address) = address_of(&zero);
    at(channel(1) + write_address) = spi_data;
    at(channel(1) + control) = channel_setup(1, 16, quiet);  // DREQ_SPI0_TX
    at(dma + 0x404U) = 1;                                    // INTE0: channel 0
    enable_interrupt(dma_interrupt);
  }

  std::uint32_t divisor_ = 0;
};

using Board = Rp2040;

}  // namespace boards
