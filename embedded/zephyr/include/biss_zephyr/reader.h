/* The core of the driver, in C++: an axis that is read with transfers of the driver. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Receives bytes, which are ones before. Returns 0, or a negative error. */
typedef int (*biss_transfer)(const void* context, uint8_t* bytes, size_t size);

struct biss_reader_setup {
  const char* frame_format;
  uint32_t clock_hz;
  uint32_t line_delay_max_ns;
  uint32_t processing_time_max_ns;
  uint32_t max_step; /* 0: half of the encoder's range */
  bool no_error_flag;
  bool unchecked;
};

/* `position` is the encoder's count, without turns. */
struct biss_sample {
  uint64_t position;
  bool warning;
  uint16_t line_delay_clocks;
};

/* Room for the axis and its two buffers; biss_reader.cpp checks that it is enough. */
struct biss_reader {
  uint64_t storage[(704 + 2 * CONFIG_BISS_ENCODER_BYTES) / 8];
};

/* Returns the number of bytes to transfer, or -EINVAL if the format or a limit is not valid, or if
 * the format lacks nE or CRC and the setup does not permit this. */
int biss_reader_init(struct biss_reader* reader, const struct biss_reader_setup* setup,
                     biss_transfer transfer, const void* context);

/* Requests a position. Returns 0, or an error of biss_zephyr/encoder.h; then *sample is unchanged.
 * -EAGAIN: call it again after the encoder's timeout; a position needs two frames that agree. */
int biss_reader_fetch(struct biss_reader* reader, int64_t uptime_ms, struct biss_sample* sample);

#ifdef __cplusplus
}
#endif
