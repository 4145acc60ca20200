// Runs the sensor driver of the Zephyr module on a PC: prints the results of init for different
// setups, and then of sample_fetch and of channel_get for each channel.
#include <cstdio>
#include <initializer_list>
#include <span>

#include "biss/frame/format_text.hpp"
#include "embedded/stubs/line.hpp"

#include <biss_zephyr/driver.h>
#include <biss_zephyr/encoder.h>

namespace {

bool spi_ready = false;
int spi_result = 0;
std::int64_t uptime_ms = 0;
int locks = 0;
std::uint64_t first = 200000;  // three quarters of a rotation

void print_setup(const char* what, std::uint32_t clock_hz, biss_encoder_config config) {
  static biss_encoder_data data;
  config.spi.config.frequency = clock_hz;
  if (config.line_delay_max_ns == 0) config.line_delay_max_ns = 1000;
  if (config.processing_time_max_ns == 0) config.processing_time_max_ns = 10000;
  const device encoder{what, &config, nullptr, &data, biss_encoder_init};
  std::printf("%s: %d\n", what, encoder.init(&encoder));
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

int main() {
  std::printf("init %d\n", biss_test_encoder.init(&biss_test_encoder));
  spi_ready = true;
  const char* const format = "pos18,nE,nW,crc6";
  print_setup("format", 4000000, {.frame_format = "pos18,nE,nW,crc99"});
  print_setup("position", 4000000, {.frame_format = "nE,nW,crc6"});
  print_setup("no clock", 0, {.frame_format = format});
  print_setup("12 MHz", 12000000, {.frame_format = format});
  print_setup("ACK", 4000000, {.frame_format = format, .processing_time_max_ns = 40001});
  print_setup("no nE", 4000000, {.frame_format = "pos18,crc6"});
  print_setup("no nE, permitted", 4000000, {.frame_format = "pos18,crc6", .no_error_flag = true});
  print_setup("no CRC", 4000000, {.frame_format = "pos18,nE,nW"});
  print_setup("no CRC, permitted", 4000000, {.frame_format = "pos18,nE,nW", .unchecked = true});
  print_setup("half a turn", 4000000, {.frame_format = format, .max_step = 1 << 17});
  print_setup("a step", 4000000, {.frame_format = format, .max_step = 1000});
  print_setup("rotation", 4000000, {.frame_format = format, .rotation_bits = 33});
  // 2 + 400 leading ones, 400 clocks of ACK, 3 + 26.
  print_setup(
      "104 bytes", 10000000,
      {.frame_format = format, .line_delay_max_ns = 40000, .processing_time_max_ns = 40000});
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
