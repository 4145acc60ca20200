/* Sensor driver of Zephyr for encoders with the BiSS C interface; see biss_zephyr/encoder.h. */
#define DT_DRV_COMPAT biss_c_encoder

#include <errno.h>

#include <zephyr/device.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/drivers/spi.h>
#include <zephyr/kernel.h>
#include <zephyr/logging/log.h>

#include <biss_zephyr/encoder.h>

#include <biss_zephyr/reader.h>

LOG_MODULE_REGISTER(biss_encoder, CONFIG_SENSOR_LOG_LEVEL);

/* SPI mode 3: MA is idle high, SLO is sampled at its rising edge. */
#define BISS_SPI_OPERATION \
  (SPI_OP_MODE_MASTER | SPI_TRANSFER_MSB | SPI_WORD_SET(8) | SPI_MODE_CPOL | SPI_MODE_CPHA)

/* The longest timeout of an encoder: between two requests of a fetch. */
#define BISS_TIMEOUT_US 40

struct biss_encoder_config {
  struct spi_dt_spec spi;
  struct biss_reader_setup setup;
  uint8_t rotation_bits;
};

struct biss_encoder_data {
  struct k_mutex lock;
  struct biss_reader reader;
  struct biss_sample sample;
  bool fetched;
};

static int biss_encoder_transfer(const void* spi, uint8_t* bytes, size_t size) {
  const struct spi_buf buffer = {.buf = bytes, .len = size};
  const struct spi_buf_set receive = {.buffers = &buffer, .count = 1};

  return spi_read_dt(spi, &receive);
}

static int biss_encoder_fetch(const struct device* dev, enum sensor_channel chan) {
  struct biss_encoder_data* data = dev->data;
  int result;

  if (chan != SENSOR_CHAN_ALL && chan != SENSOR_CHAN_ROTATION &&
      (int)chan != SENSOR_CHAN_BISS_POSITION) {
    return -ENOTSUP;
  }

  k_mutex_lock(&data->lock, K_FOREVER);
  result = biss_reader_fetch(&data->reader, k_uptime_get(), &data->sample);
  for (int further = 2; result == -EAGAIN && further > 0; --further) {
    k_busy_wait(BISS_TIMEOUT_US);
    result = biss_reader_fetch(&data->reader, k_uptime_get(), &data->sample);
  }
  data->fetched |= result == 0;
  k_mutex_unlock(&data->lock);
  return result;
}

/* The angle of the position within its rotation, in degrees and millionths of a degree. */
static int biss_encoder_rotation(uint64_t position, uint8_t bits, struct sensor_value* value) {
  if (bits == 0) {
    return -ENOTSUP;
  }

  const uint64_t count = position & ((UINT64_C(1) << bits) - 1);
  const uint64_t millionths = (count * UINT64_C(360000000)) >> bits;

  value->val1 = (int32_t)(millionths / 1000000);
  value->val2 = (int32_t)(millionths % 1000000);
  return 0;
}

static int biss_encoder_get(const struct device* dev, enum sensor_channel chan,
                            struct sensor_value* value) {
  const struct biss_encoder_config* config = dev->config;
  struct biss_encoder_data* data = dev->data;

  k_mutex_lock(&data->lock, K_FOREVER);
  const struct biss_sample sample = data->sample;
  const bool fetched = data->fetched;
  k_mutex_unlock(&data->lock);
  if (!fetched) {
    return -ENODATA;
  }

  value->val2 = 0;
  switch ((int)chan) {
    case SENSOR_CHAN_ROTATION:
      return biss_encoder_rotation(sample.position, config->rotation_bits, value);
    case SENSOR_CHAN_BISS_POSITION:
      value->val1 = (int32_t)(uint32_t)(sample.position >> 32);
      value->val2 = (int32_t)(uint32_t)sample.position;
      return 0;
    case SENSOR_CHAN_BISS_WARNING:
      value->val1 = sample.warning;
      return 0;
    case SENSOR_CHAN_BISS_LINE_DELAY:
      value->val1 = sample.line_delay_clocks;
      return 0;
    default:
      return -ENOTSUP;
  }
}

static int biss_encoder_init(const struct device* dev) {
  const struct biss_encoder_config* config = dev->config;
  struct biss_encoder_data* data = dev->data;
  int bytes;

  k_mutex_init(&data->lock);
  if (!spi_is_ready_dt(&config->spi)) {
    LOG_ERR("%s: the SPI controller is not ready", dev->name);
    return -ENODEV;
  }
  bytes = biss_reader_init(&data->reader, &config->setup, biss_encoder_transfer, &config->spi);
  if (bytes < 0 || config->rotation_bits > 32) {
    LOG_ERR("%s: biss-format \"%s\" or a limit is not valid, or lacks nE or CRC", dev->name,
            config->setup.frame_format);
    return -EINVAL;
  }
  if (bytes > CONFIG_BISS_ENCODER_BYTES) {
    LOG_ERR("%s: needs BISS_ENCODER_BYTES=%d", dev->name, bytes);
    return -ENOMEM;
  }
  return 0;
}

static const struct sensor_driver_api biss_encoder_api = {
    .sample_fetch = biss_encoder_fetch,
    .channel_get = biss_encoder_get,
};

#define BISS_ENCODER_DEFINE(inst)                                                        \
  static struct biss_encoder_data biss_encoder_data_##inst;                              \
  static const struct biss_encoder_config biss_encoder_config_##inst = {                 \
      .spi = SPI_DT_SPEC_INST_GET(inst, BISS_SPI_OPERATION, 0),                          \
      .setup =                                                                           \
          {                                                                              \
              .frame_format = DT_INST_PROP(inst, biss_format),                           \
              .clock_hz = DT_INST_PROP(inst, spi_max_frequency),                         \
              .line_delay_max_ns = DT_INST_PROP(inst, line_delay_max_ns),                \
              .processing_time_max_ns = DT_INST_PROP(inst, processing_time_max_ns),      \
              .max_step = DT_INST_PROP_OR(inst, max_step, 0),                            \
              .no_error_flag = DT_INST_PROP(inst, no_error_flag),                        \
              .unchecked = DT_INST_PROP(inst, unchecked),                                \
          },                                                                             \
      .rotation_bits = DT_INST_PROP_OR(inst, rotation_bits, 0),                          \
  };                                                                                     \
  SENSOR_DEVICE_DT_INST_DEFINE(inst, biss_encoder_init, NULL, &biss_encoder_data_##inst, \
                               &biss_encoder_config_##inst, POST_KERNEL,                 \
                               CONFIG_SENSOR_INIT_PRIORITY, &biss_encoder_api);

DT_INST_FOREACH_STATUS_OKAY(BISS_ENCODER_DEFINE)
