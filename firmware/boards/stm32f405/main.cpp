// Reads an encoder on the STM32F405: the interrupts and the start of the program.
#include "firmware/boards/read_encoder.hpp"
#include "firmware/boards/stm32f405/board.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"

namespace {

constinit boards::Stm32f405 board;
constinit boards::ReadEncoder<boards::Stm32f405> program{board};

}  // namespace

extern "C" void systick_handler() { program.cycle(); }

extern "C" void dma_complete_handler() {
  board.acknowledge() ? program.transfer_complete() : program.transfer_failed();
}

void firmware::write(const char* text) {
  for (; *text != '\0'; ++text) boards::Stm32f405::put(*text);
}

void firmware::exit(int status) {
  boards::write_number("end, status ", static_cast<std::uint64_t>(status));
  firmware::write("\n");
  for (;;) boards::wait_for_interrupt();
}

int firmware_main() {
#ifndef BISS_EMULATED  // the registers of clocks read as 0 in QEMU
  boards::stm32f405::clock_setup();
#endif
  board.setup();
  return program.run();
}
