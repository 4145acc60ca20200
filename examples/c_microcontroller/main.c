/* Firmware in C that reads an encoder with an SPI peripheral: no heap, no text of a format, no
 * table of encoders. docs/c.md compiles it without CMake. */
#include <biss_c_axis.h>

#define PERIOD_PS 100000   /* MA at 10 MHz */
#define CYCLE_PS 100000000 /* a request every 100 us */

/* "pos26,nE,nW,crc6;cds0": 28 data bits, of which the last ones are nE and nW. */
static const biss_channel_format channel = {
    .data_bits = 28,
    .position = {.shift = 2, .bits = 26},
    .error = {.shift = 1, .present = true},
    .warning = {.shift = 0, .present = true},
    .crc = {.polynomial = 0x43, .width_bits = 6, .inverted = true}};

static biss_spi reader;
static biss_axis axis;
static volatile int64_t clock_ps; /* of your timer */

/* Your driver: starts a DMA transfer of `count` bytes; false if the last one has not ended. */
static bool start_dma(void* spi, uint8_t* bytes, size_t count) {
  (void)spi;
  (void)bytes;
  return count != 0;
}
/* Your control loop. */
static void control(int64_t position, int64_t step) { (void)(position + step); }
static void stop_the_drive(biss_axis_cause cause) { (void)cause; }

/* Interrupts of the same priority. */
void control_timer_interrupt(void) {
  biss_axis_position now;
  biss_axis_get(&axis, &now);
  if (now.usable) {
    control(now.position, now.step);
  } else if (now.state == BISS_AXIS_STOPPED) {
    stop_the_drive(now.cause);
  }
  biss_axis_request(&axis, clock_ps);
}
void dma_complete_interrupt(void) { biss_axis_complete(&axis); }
void dma_error_interrupt(void) { biss_axis_failed(&axis); }

int main(void) {
  biss_format format = biss_format_defaults();
  format.channel_count = 1;
  format.cds0 = true;
  format.channels[0] = channel;
  format.timing.ack_max_ps = 14000000; /* of the data sheet: it makes the buffer short */
  format.timing.sampling_typical_ps = 3250000;
  biss_spi_setup spi = biss_spi_defaults(&format, PERIOD_PS);
  spi.line_delay_max_ps = 700000; /* 70 m of cable */
  biss_status status = biss_spi_init(&reader, &spi);
  /* 3000 turns per minute of 2^26 counts, in one cycle and an eighth. */
  biss_axis_setup setup = biss_axis_defaults(&reader, CYCLE_PS, 380000);
  setup.start = start_dma;
  if (status == BISS_OK) status = biss_axis_init(&axis, &setup);
  if (status != BISS_OK) return 1;
  for (;;) { /* the interrupts do the work; here they are called in turn */
    clock_ps += CYCLE_PS;
    control_timer_interrupt();
    dma_complete_interrupt();
  }
}
