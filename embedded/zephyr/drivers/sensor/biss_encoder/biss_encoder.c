/* The instances of the sensor driver for encoders with the BiSS C interface; see
 * biss_zephyr/encoder.h. */
#define DT_DRV_COMPAT biss_c_encoder

#include <biss_zephyr/driver.h>

/* SPI mode 3: MA is idle high, SLO is sampled at its rising edge. */
#define BISS_SPI_OPERATION \
  (SPI_OP_MODE_MASTER | SPI_TRANSFER_MSB | SPI_WORD_SET(8) | SPI_MODE_CPOL | SPI_MODE_CPHA)

static const struct sensor_driver_api biss_encoder_api = {
    .sample_fetch = biss_encoder_fetch,
    .channel_get = biss_encoder_get,
};

#define BISS_ENCODER_DEFINE(inst)                                                        \
  static struct biss_encoder_data biss_encoder_data_##inst;                              \
  static const struct biss_encoder_config biss_encoder_config_##inst = {                 \
      .spi = SPI_DT_SPEC_INST_GET(inst, BISS_SPI_OPERATION, 0),                          \
      .frame_format = DT_INST_PROP(inst, biss_format),                                   \
      .line_delay_max_ns = DT_INST_PROP(inst, line_delay_max_ns),                        \
      .processing_time_max_ns = DT_INST_PROP(inst, processing_time_max_ns),              \
      .max_step = DT_INST_PROP_OR(inst, max_step, 0),                                    \
      .rotation_bits = DT_INST_PROP_OR(inst, rotation_bits, 0),                          \
      .no_error_flag = DT_INST_PROP(inst, no_error_flag),                                \
      .unchecked = DT_INST_PROP(inst, unchecked),                                        \
  };                                                                                     \
  SENSOR_DEVICE_DT_INST_DEFINE(inst, biss_encoder_init, NULL, &biss_encoder_data_##inst, \
                               &biss_encoder_config_##inst, POST_KERNEL,                 \
                               CONFIG_SENSOR_INIT_PRIORITY, &biss_encoder_api);

DT_INST_FOREACH_STATUS_OKAY(BISS_ENCODER_DEFINE)
