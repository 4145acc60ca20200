// The program of the examples on one board, whose folder the build adds to the include path.
#include <board.hpp>

#include "firmware/boards/read_encoder.hpp"
#include "firmware/platform/console.hpp"
#include "firmware/platform/startup.hpp"

[[gnu::section(".noinit")]] biss::RecordBytes boards::kept_record;

namespace {

constinit boards::Board board;
constinit boards::ReadEncoder<boards::Board> program{board};

}  // namespace

extern "C" void systick_handler() { program.cycle(); }

extern "C" void dma_complete_handler() { program.transfer_ended(board.acknowledge()); }

void firmware::write(const char* text) {
  for (; *text != '\0'; ++text) boards::Board::put(*text);
}

void firmware::exit(int status) {
  boards::stop_cycle_timer();
  firmware::print("end, status ", static_cast<std::uint64_t>(status), "\n");
  for (;;) boards::wait_for_interrupt();
}

int firmware_main() {
  board.setup();
  return program.run();
}
