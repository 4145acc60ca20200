/* The sensor interface of Zephyr, as its API reference describes it. */
#pragma once

#include <zephyr/device.h>

struct sensor_value {
  int32_t val1;
  int32_t val2;
};

enum sensor_channel {
  SENSOR_CHAN_ROTATION = 30,
  SENSOR_CHAN_ALL,
  SENSOR_CHAN_COMMON_COUNT,
  SENSOR_CHAN_PRIV_START = SENSOR_CHAN_COMMON_COUNT,
};

typedef int (*sensor_sample_fetch_t)(const struct device* dev, enum sensor_channel chan);
typedef int (*sensor_channel_get_t)(const struct device* dev, enum sensor_channel chan,
                                    struct sensor_value* val);

struct sensor_driver_api {
  sensor_sample_fetch_t sample_fetch;
  sensor_channel_get_t channel_get;
};

static inline int sensor_sample_fetch(const struct device* dev) {
  return ((const struct sensor_driver_api*)dev->api)->sample_fetch(dev, SENSOR_CHAN_ALL);
}

static inline int sensor_channel_get(const struct device* dev, enum sensor_channel chan,
                                     struct sensor_value* val) {
  return ((const struct sensor_driver_api*)dev->api)->channel_get(dev, chan, val);
}

#define SENSOR_DEVICE_DT_INST_DEFINE(inst, init_fn, pm, data_ptr, cfg_ptr, level, prio, api_ptr) \
  enum { prio_of_##inst = (prio) };                                                              \
  const struct device biss_test_encoder = {"encoder", cfg_ptr, api_ptr, data_ptr, init_fn};
