/* The core of the driver, in C++: finds the frame in the bytes of a transfer. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Room for one reader; biss_reader.cpp checks that it is enough. */
#define BISS_READER_BYTES 1024

struct biss_reader {
  uint64_t storage[BISS_READER_BYTES / 8];
};

struct biss_reader_setup {
  const char* frame_format;
  uint32_t clock_hz;
  uint32_t line_delay_max_ns;
  uint32_t processing_time_max_ns;
  bool no_error_flag;
  bool unchecked;
};

struct biss_sample {
  uint64_t position;
  bool warning;
  uint16_t line_delay_clocks;
};

/* Returns the number of bytes to transfer, or -EINVAL if the format or a limit is not valid, or if
 * the format lacks nE or CRC and the setup does not permit this. */
int biss_reader_init(struct biss_reader* reader, const struct biss_reader_setup* setup);

/* Returns 0, or an error of biss_zephyr/encoder.h; then *sample is unchanged. */
int biss_reader_read(const struct biss_reader* reader, const uint8_t* bytes, size_t size,
                     struct biss_sample* sample);

#ifdef __cplusplus
}
#endif
