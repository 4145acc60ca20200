/* The driver: its instances are in C (biss_encoder.c), because devicetree macros are C; its
 * functions in C++ (biss_axis.cpp), because the axis is C++. */
#pragma once

#include <zephyr/device.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/drivers/spi.h>
#include <zephyr/kernel.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The properties of the node, and its spi-max-frequency in `spi`. */
struct biss_encoder_config {
  struct spi_dt_spec spi;
  const char* frame_format;
  uint32_t line_delay_max_ns;
  uint32_t processing_time_max_ns;
  uint32_t max_step; /* 0: half of the encoder's range */
  uint8_t rotation_bits;
  bool no_error_flag;
  bool unchecked;
};

struct biss_encoder_data {
  struct k_mutex lock;
  /* The last fetch that was good; `position` is the encoder's count, without turns. */
  bool fetched;
  bool warning;
  uint16_t line_delay_clocks;
  uint64_t position;
  /* Room for the axis and its two buffers; biss_axis.cpp checks that it is enough. */
  uint64_t axis[(704 + 2 * CONFIG_BISS_ENCODER_BYTES) / 8];
};

int biss_encoder_init(const struct device* dev);
int biss_encoder_fetch(const struct device* dev, enum sensor_channel chan);
int biss_encoder_get(const struct device* dev, enum sensor_channel chan,
                     struct sensor_value* value);

#ifdef __cplusplus
}
#endif
