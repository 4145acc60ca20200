// The second stage of the boot loader: makes the flash readable and starts the image. The ROM
// copies these 256 bytes to RAM, checks their CRC (set by make-uf2) and calls them.
//
// RP2040 data sheet, 2.8.1.3 (second stage) and 4.10 (SSI): standard SPI, command 03h, 24 address
// bits, clk_sys / 4.
extern "C" [[gnu::naked, gnu::used, gnu::section(".boot2")]] void second_stage() {
  asm volatile(
      "ldr r0, =0x18000000\n"  // SSI
      "movs r1, #0\n"
      "str r1, [r0, #0x08]\n"  // SSIENR: off
      "movs r2, #4\n"
      "str r2, [r0, #0x14]\n"  // BAUDR
      "ldr r2, =0x001F0300\n"  // 32-bit data frames, read with EEPROM commands
      "str r2, [r0, #0x00]\n"  // CTRLR0
      "str r1, [r0, #0x04]\n"  // CTRLR1: one data frame
      "ldr r2, =0x03000218\n"  // command 03h, 8 command bits, 24 address bits
      "movs r3, #0xF4\n"
      "str r2, [r0, r3]\n"  // SPI_CTRLR0
      "movs r1, #1\n"
      "str r1, [r0, #0x08]\n"  // SSIENR: on
      "ldr r0, =0x10000100\n"  // the vector table
      "ldr r1, =0xE000ED08\n"  // VTOR
      "str r0, [r1]\n"
      "ldr r1, [r0, #0]\n"
      "msr msp, r1\n"
      "ldr r1, [r0, #4]\n"
      "bx r1\n"
      ".ltorg\n");
}
