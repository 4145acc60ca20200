// Runs the sensor driver of the Zephyr module on a PC: the results of sample_fetch and channel_get
// for good and for damaged lines, and the setups that init refuses.
#include <cerrno>
#include <cstdio>

#include "biss/frame/format_text.hpp"
#include "embedded/stubs/line.hpp"

extern "C" {
#include <biss_zephyr/encoder.h>
#include <zephyr/drivers/spi.h>
#include <zephyr/kernel.h>

#include <biss_zephyr/reader.h>

int k_mutex_init(k_mutex* mutex) {
  mutex->count = 0;
  return 0;
}
int k_mutex_lock(k_mutex* mutex, int) {
  ++mutex->count;
  return 0;
}
int k_mutex_unlock(k_mutex* mutex) {
  --mutex->count;
  return 0;
}
}

namespace {

bool spi_ready = true;
int spi_result = 0;
stubs::LineFault fault = stubs::LineFault::none;
std::uint64_t position = 0;
int wrong = 0;

void expect_equal(const char* what, long long value, long long expected) {
  if (value == expected) return;
  std::printf("%s: %lld, expected %lld\n", what, value, expected);
  ++wrong;
}

int fetch(stubs::LineFault with) {
  fault = with;
  return sensor_sample_fetch(&biss_test_encoder);
}

sensor_value get(int channel) {
  sensor_value value{-1, -1};
  expect_equal("channel_get",
               sensor_channel_get(&biss_test_encoder, static_cast<sensor_channel>(channel), &value),
               0);
  return value;
}

void check_init() {
  spi_ready = false;
  expect_equal("init without SPI", biss_test_encoder.init(&biss_test_encoder), -ENODEV);
  spi_ready = true;
  expect_equal("init", biss_test_encoder.init(&biss_test_encoder), 0);
}

void check_samples() {
  sensor_value value{};
  expect_equal("get before fetch",
               sensor_channel_get(&biss_test_encoder, SENSOR_CHAN_ROTATION, &value), -ENODATA);
  position = 3U << 16U;  // three quarters of a rotation
  expect_equal("fetch", fetch(stubs::LineFault::none), 0);
  expect_equal("degrees", get(SENSOR_CHAN_ROTATION).val1, 270);
  expect_equal("millionths", get(SENSOR_CHAN_ROTATION).val2, 0);
  expect_equal("position", get(SENSOR_CHAN_BISS_POSITION).val2, 3 << 16);
  expect_equal("upper half", get(SENSOR_CHAN_BISS_POSITION).val1, 0);
  expect_equal("warning", get(SENSOR_CHAN_BISS_WARNING).val1, 0);
  expect_equal("line delay", get(SENSOR_CHAN_BISS_LINE_DELAY).val1, 1);
  position = 1;
  expect_equal("fetch", fetch(stubs::LineFault::none), 0);
  expect_equal("millionths of a count", get(SENSOR_CHAN_ROTATION).val2, 360000000LL >> 18);
  expect_equal("unknown channel", sensor_channel_get(&biss_test_encoder, SENSOR_CHAN_ALL, &value),
               -ENOTSUP);
}

void check_faults() {
  expect_equal("no_response", fetch(stubs::LineFault::no_response), -ENODEV);
  position = 77;
  expect_equal("fetch", fetch(stubs::LineFault::none), 0);
  position = 99;
  expect_equal("nothing written", fetch(stubs::LineFault::no_dma), -ENODEV);
  expect_equal("crc", fetch(stubs::LineFault::crc), -EBADMSG);
  expect_equal("nE = 0", fetch(stubs::LineFault::error_bit), -EFAULT);
  spi_result = -EIO;
  expect_equal("SPI", fetch(stubs::LineFault::none), -EIO);
  spi_result = 0;
  expect_equal("the last good position", get(SENSOR_CHAN_BISS_POSITION).val2, 77);
}

void check_formats() {
  biss_reader reader{};
  biss_reader_setup setup{"pos18,nE,nW,crc6", 4000000, 1000, 10000, false, false};
  // 2 + 4 leading ones, 40 clocks of ACK, 3 + 26.
  expect_equal("bytes", biss_reader_init(&reader, &setup), (2 + 4 + 40 + 3 + 26 + 7) / 8);
  setup.frame_format = "pos18,nE,nW,crc99";
  expect_equal("no format", biss_reader_init(&reader, &setup), -EINVAL);
  setup.frame_format = "nE,nW,crc6";
  expect_equal("no position", biss_reader_init(&reader, &setup), -EINVAL);
  setup = {"pos18,nE,nW,crc6", 0, 1000, 10000, false, false};
  expect_equal("no clock", biss_reader_init(&reader, &setup), -EINVAL);
  setup = {"pos18,nE,nW,crc6", 4000000, 1000, 40001, false, false};
  expect_equal("processing time", biss_reader_init(&reader, &setup), -EINVAL);
  setup = {"pos18,nE,nW,crc6", 12000000, 1000, 10000, false, false};
  expect_equal("clock above 10 MHz", biss_reader_init(&reader, &setup), -EINVAL);
  setup = {"pos18,crc6", 4000000, 1000, 10000, false, false};
  expect_equal("no nE", biss_reader_init(&reader, &setup), -EINVAL);
  setup.no_error_flag = true;
  expect_equal("no nE, permitted", biss_reader_init(&reader, &setup) > 0, 1);
  setup = {"pos18,nE,nW", 4000000, 1000, 10000, false, false};
  expect_equal("no CRC", biss_reader_init(&reader, &setup), -EINVAL);
  setup.unchecked = true;
  expect_equal("no CRC, permitted", biss_reader_init(&reader, &setup) > 0, 1);
}

}  // namespace

extern "C" {

bool spi_is_ready_dt(const spi_dt_spec*) { return spi_ready; }

int spi_read_dt(const spi_dt_spec* spec, const spi_buf_set* receive) {
  constexpr auto mode =
      SPI_OP_MODE_MASTER | SPI_TRANSFER_MSB | SPI_WORD_SET(8) | SPI_MODE_CPOL | SPI_MODE_CPHA;
  expect_equal("mode", spec->config.operation, static_cast<long long>(mode));
  expect_equal("frequency", spec->config.frequency, 4000000);
  if (spi_result != 0) return spi_result;
  const std::span bytes(static_cast<std::uint8_t*>(receive->buffers[0].buf),
                        receive->buffers[0].len);
  stubs::receive(bytes, biss::frame_format("pos18,nE,nW,crc6"), position, 12, fault);
  return 0;
}
}

int main() {
  check_init();
  check_samples();
  check_faults();
  check_formats();
  expect_equal("locks held", static_cast<const k_mutex*>(biss_test_encoder.data)->count, 0);
  std::printf("Zephyr driver: %d wrong\n", wrong);
  return wrong == 0 ? 0 : 1;
}
