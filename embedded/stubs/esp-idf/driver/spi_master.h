// The parts of the SPI master driver of ESP-IDF 5 that the example uses (its API reference).
#pragma once

#include <cstddef>
#include <cstdint>

#include <freertos/FreeRTOS.h>

using esp_err_t = int;
inline constexpr esp_err_t ESP_OK = 0;
void esp_error_check_failed(esp_err_t error);
#define ESP_ERROR_CHECK(call)                               \
  do {                                                      \
    const esp_err_t checked = (call);                       \
    if (checked != ESP_OK) esp_error_check_failed(checked); \
  } while (0)

enum spi_host_device_t { SPI2_HOST = 1 };
enum spi_dma_chan_t { SPI_DMA_CH_AUTO = 3 };
struct spi_device_t;
using spi_device_handle_t = spi_device_t*;

struct spi_bus_config_t {
  int mosi_io_num;
  int miso_io_num;
  int sclk_io_num;
  int quadwp_io_num;
  int quadhd_io_num;
};

struct spi_device_interface_config_t {
  std::uint8_t mode;
  int clock_speed_hz;
  int spics_io_num;
  int queue_size;
};

struct spi_transaction_t {
  std::size_t length;  // bits
  void* rx_buffer;
};

esp_err_t spi_bus_initialize(spi_host_device_t host, const spi_bus_config_t* bus,
                             spi_dma_chan_t dma);
esp_err_t spi_bus_add_device(spi_host_device_t host, const spi_device_interface_config_t* device,
                             spi_device_handle_t* handle);
esp_err_t spi_device_queue_trans(spi_device_handle_t handle, spi_transaction_t* transaction,
                                 TickType_t wait);
esp_err_t spi_device_get_trans_result(spi_device_handle_t handle, spi_transaction_t** transaction,
                                      TickType_t wait);
