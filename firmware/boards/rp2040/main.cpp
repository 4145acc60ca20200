// Reads an encoder on the RP2040: the interrupts and the start of the program.
#include "firmware/boards/read_encoder.hpp"
#include "firmware/boards/rp2040/board.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"

namespace {

constinit boards::Rp2040 board;
constinit boards::ReadEncoder<boards::Rp2040> program{board};

}  // namespace

extern "C" void systick_handler() { program.cycle(); }

extern "C" void dma_complete_handler() {
  board.acknowledge() ? program.transfer_complete() : program.transfer_failed();
}

void firmware::write(const char* text) {
  for (; *text != '\0'; ++text) boards::Rp2040::put(*text);
}

void firmware::exit(int status) {
  boards::write_number("end, status ", static_cast<std::uint64_t>(status));
  firmware::write("\n");
  for (;;) boards::wait_for_interrupt();
}

int firmware_main() {
  board.setup();
  return program.run();
}
