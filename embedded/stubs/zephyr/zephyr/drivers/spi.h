/* The SPI interface of Zephyr, as its API reference describes it. */
#pragma once

#include <zephyr/device.h>

#define BIT(n) (1UL << (n))
#define SPI_OP_MODE_MASTER 0U
#define SPI_MODE_CPOL BIT(1)
#define SPI_MODE_CPHA BIT(2)
#define SPI_TRANSFER_MSB (0U)
#define SPI_WORD_SET(bits) ((bits) << 5U)

struct spi_buf {
  void* buf;
  size_t len;
};

struct spi_buf_set {
  const struct spi_buf* buffers;
  size_t count;
};

struct spi_config {
  uint32_t frequency;
  uint32_t operation;
};

struct spi_dt_spec {
  const struct device* bus;
  struct spi_config config;
};

bool spi_is_ready_dt(const struct spi_dt_spec* spec);
int spi_read_dt(const struct spi_dt_spec* spec, const struct spi_buf_set* rx);

#define SPI_DT_SPEC_INST_GET(inst, operation_, ...)       \
  {                                                       \
    .bus = NULL, .config = {                              \
      .frequency = DT_INST_PROP(inst, spi_max_frequency), \
      .operation = (operation_),                          \
    }                                                     \
  }
