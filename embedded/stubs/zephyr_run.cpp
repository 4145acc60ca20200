// Runs the sensor driver of the Zephyr module on a PC: prints the results of init for different
// setups, and then of sample_fetch and of channel_get for each channel.
#include <cstdio>
#include <initializer_list>
#include <span>

#include "biss/frame/format_text.hpp"
#include "embedded/stubs/line.hpp"

extern "C" {
#include <biss_zephyr/encoder.h>
#include <zephyr/drivers/spi.h>
#include <zephyr/kernel.h>

#include <biss_zephyr/reader.h>
}

namespace {

bool spi_ready = false;
int spi_result = 0;
std::int64_t uptime_ms = 0;
int locks = 0;
std::uint64_t first = 200000;  // three quarters of a rotation

void print_setup(const char* what, const biss_reader_setup& setup) {
  static biss_reader reader;
  std::printf("%s: %d\n", what, biss_reader_init(&reader, &setup, nullptr, nullptr));
}

void fetch() {
  std::printf("fetch %d", sensor_sample_fetch(&biss_test_encoder));
  for (const int channel :
       {int{SENSOR_CHAN_ROTATION}, int{SENSOR_CHAN_BISS_POSITION}, int{SENSOR_CHAN_BISS_WARNING},
        int{SENSOR_CHAN_BISS_LINE_DELAY}, int{SENSOR_CHAN_ALL}}) {
    sensor_value value{-1, -1};
    const int result =
        sensor_channel_get(&biss_test_encoder, static_cast<sensor_channel>(channel), &value);
    std::printf(", %d: %d %d", result, value.val1, value.val2);
  }
  std::printf("\n");
}

}  // namespace

extern "C" {

int k_mutex_init(k_mutex*) { return 0; }
int k_mutex_lock(k_mutex*, int) { return locks++; }
int k_mutex_unlock(k_mutex*) { return --locks; }
void k_busy_wait(uint32_t) {}
int64_t k_uptime_get(void) { return uptime_ms; }
bool spi_is_ready_dt(const spi_dt_spec*) { return spi_ready; }

int spi_read_dt(const spi_dt_spec* spec, const spi_buf_set* receive) {
  constexpr auto mode =
      SPI_OP_MODE_MASTER | SPI_TRANSFER_MSB | SPI_WORD_SET(8) | SPI_MODE_CPOL | SPI_MODE_CPHA;
  if (spec->config.operation != mode || spec->config.frequency != 4000000) std::printf("mode\n");
  if (spi_result != 0) return spi_result;
  const auto& buffer = receive->buffers[0];
  stubs::receive({static_cast<std::uint8_t*>(buffer.buf), buffer.len},
                 biss::frame_format("pos18,nE,nW,crc6"), first, 12);
  return 0;
}
}

int main() {
  print_setup("format", {"pos18,nE,nW,crc99", 4000000, 1000, 10000, 0, false, false});
  print_setup("position", {"nE,nW,crc6", 4000000, 1000, 10000, 0, false, false});
  print_setup("no clock", {"pos18,nE,nW,crc6", 0, 1000, 10000, 0, false, false});
  print_setup("12 MHz", {"pos18,nE,nW,crc6", 12000000, 1000, 10000, 0, false, false});
  print_setup("ACK", {"pos18,nE,nW,crc6", 4000000, 1000, 40001, 0, false, false});
  print_setup("no nE", {"pos18,crc6", 4000000, 1000, 10000, 0, false, false});
  print_setup("no nE, permitted", {"pos18,crc6", 4000000, 1000, 10000, 0, true, false});
  print_setup("no CRC", {"pos18,nE,nW", 4000000, 1000, 10000, 0, false, false});
  print_setup("no CRC, permitted", {"pos18,nE,nW", 4000000, 1000, 10000, 0, false, true});
  print_setup("half a turn", {"pos18,nE,nW,crc6", 4000000, 1000, 10000, 1 << 17, false, false});
  // 2 + 4 leading ones, 40 clocks of ACK, 3 + 26.
  print_setup("bytes", {"pos18,nE,nW,crc6", 4000000, 1000, 10000, 1000, false, false});
  std::printf("init %d\n", biss_test_encoder.init(&biss_test_encoder));
  spi_ready = true;
  std::printf("init %d\n", biss_test_encoder.init(&biss_test_encoder));
  spi_result = -EIO;
  fetch();
  for (spi_result = 0; !stubs::done(); uptime_ms += 100) fetch();
  // No fetch for 200 s, and then a step of more than max-step.
  uptime_ms += 200000;
  stubs::transfers = 12;
  fetch();
  first += 2000;
  stubs::transfers = 14;
  fetch();
  std::printf("locks: %d\n", locks);
}
