/* Firmware in C that reads an encoder with an SPI peripheral: no heap, no text of a format, no
 * table of encoders. docs/c.md compiles it without CMake. */
#include <biss_c_frame.h>

#define PERIOD_PS 100000 /* MA at 10 MHz */

/* "pos26,nE,nW,crc6;cds0": 28 data bits, of which the last ones are nE and nW. */
static const biss_channel_format channel = {
    .data_bits = 28,
    .position = {.shift = 2, .bits = 26},
    .error = {.shift = 1, .present = true},
    .warning = {.shift = 0, .present = true},
    .crc = {.polynomial = 0x43, .width_bits = 6, .inverted = true}};

static biss_spi reader;
static biss_turns turns;
static uint8_t buffer[64];
volatile int64_t position; /* for the control loop */

/* Your driver: sends `count` bytes of clock and fills `bytes` with what it receives. */
static void transfer(uint8_t* bytes, size_t count) {
  for (size_t k = 0; k < count; ++k) bytes[k] = 0xFF;
}

static biss_status start(size_t* bytes) {
  biss_format format = biss_format_defaults();
  format.channel_count = 1;
  format.cds0 = true;
  format.channels[0] = channel;
  format.timing.ack_max_ps = 14000000; /* of the data sheet: it makes the buffer short */
  biss_spi_setup setup = biss_spi_defaults(&format, PERIOD_PS);
  setup.line_delay_max_ps = 700000; /* 70 m of cable */
  biss_spi_size size;
  biss_status status = biss_spi_init(&reader, &setup);
  if (status == BISS_OK) status = biss_spi_size_of(&reader, &size);
  if (status == BISS_OK && size.bytes > sizeof buffer) status = BISS_NO_ROOM;
  if (status == BISS_OK) *bytes = size.bytes;
  return status == BISS_OK ? biss_turns_init(&turns, 26, 0) : status;
}

int main(void) {
  size_t bytes = 0;
  uint64_t missed = 0;
  if (start(&bytes) != BISS_OK) return 1;
  for (;;) {
    biss_frame frame;
    biss_turns_value value;
    transfer(buffer, bytes);
    biss_spi_read(&reader, buffer, bytes, SIZE_MAX, &frame);
    if (!biss_frame_trusted(&frame)) {
      ++missed;
      continue;
    }
    biss_turns_update(&turns, frame.channels[0].position, missed, &value);
    missed = 0;
    if (value.state != BISS_TURNS_AMBIGUOUS && value.has_position) position = value.position;
  }
}
