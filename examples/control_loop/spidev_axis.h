/* An axis of biss_c_axis.h at an SPI port of Linux, for a control loop: each cycle is one system
 * call, SPI_IOC_MESSAGE, which returns when the transfer has ended. */
#pragma once

#include <biss_c_axis.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

typedef struct spidev_axis {
  int device;
  int64_t max_step;
  uint32_t turn_bits; /* counts of a turn: 2^turn_bits */
  struct spi_ioc_transfer transfer;
  biss_format format;
  biss_spi spi;
  biss_axis axis;
  bool nE; /* of the last frame with a right checksum; low-active */
  bool nW;
} spidev_axis;

static int64_t spidev_axis_now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * INT64_C(1000000000) + now.tv_nsec;
}

/* The transfer is made after biss_axis_request(), so that `start` never waits. */
static bool spidev_axis_start(void* user, uint8_t* bytes, size_t count) {
  struct spi_ioc_transfer* transfer = user;
  transfer->rx_buf = (uintptr_t)bytes;
  transfer->len = (uint32_t)count;
  return true;
}

/* Begins with turn 0, and with `cycle_ps` from one call of spidev_axis_cycle() to the next. */
static biss_status spidev_axis_begin(spidev_axis* self, int64_t cycle_ps) {
  biss_axis_setup setup = biss_axis_defaults(&self->spi, cycle_ps, self->max_step);
  setup.start = spidev_axis_start;
  setup.user = &self->transfer;
  return biss_axis_init(&self->axis, &setup);
}

/* Opens `path`, in mode 3: SCK is MA, MISO is SLO. `line_delay_max_ps`: from MA to SLO, both
 * directions of the cable and the delay of the encoder. `max_step`: the largest movement in one
 * cycle and an eighth, in counts. Returns null, or what is wrong. */
static const char* spidev_axis_open(spidev_axis* self, const char* path, const char* format,
                                    uint32_t clock_hz, int64_t line_delay_max_ps,
                                    int64_t max_step) {
  memset(self, 0, sizeof *self);
  self->device = -1;
  self->max_step = max_step;
  biss_status status = biss_format_parse(format, &self->format);
  biss_spi_setup setup =
      biss_spi_defaults(&self->format, clock_hz ? INT64_C(1000000000000) / clock_hz : 0);
  setup.line_delay_max_ps = line_delay_max_ps;
  if (status == BISS_OK) status = biss_spi_init(&self->spi, &setup);
  /* All but the cycle is checked here, before a loop runs. */
  if (status == BISS_OK) status = spidev_axis_begin(self, 1000000000);
  if (status != BISS_OK) return biss_status_text(status);
  const biss_channel_format* channel = &self->format.channels[0];
  self->turn_bits = channel->singleturn.bits ? channel->singleturn.bits : channel->position.bits;
  self->transfer.speed_hz = clock_hz;
  self->transfer.bits_per_word = 8;
  self->nE = self->nW = true;
  self->device = open(path, O_RDWR | O_CLOEXEC);
  uint8_t mode = SPI_MODE_3;
  if (self->device >= 0 && ioctl(self->device, SPI_IOC_WR_MODE, &mode) == 0) return NULL;
  return strerror(errno);
}

/* One cycle: requests a position, waits for the end of the transfer, and returns the position. */
static void spidev_axis_cycle(spidev_axis* self, biss_axis_position* position) {
  /* In picoseconds this clock wraps around. */
  biss_axis_request(&self->axis, (int64_t)((uint64_t)spidev_axis_now_ns() * 1000U));
  const uint32_t bytes = self->transfer.len;
  if (ioctl(self->device, SPI_IOC_MESSAGE(1), &self->transfer) == (int)bytes) {
    biss_frame frame;
    biss_spi_read(&self->spi, (const uint8_t*)(uintptr_t)self->transfer.rx_buf, bytes, SIZE_MAX,
                  &frame);
    if (frame.cause == BISS_CAUSE_OK) {
      self->nE = frame.channels[0].nE;
      self->nW = frame.channels[0].nW;
    }
    biss_axis_complete(&self->axis);
  } else {
    biss_axis_failed(&self->axis);
  }
  biss_axis_get(&self->axis, position);
}
