// Runs the example of the ESP-IDF component on a PC.
#include <cstdlib>
#include <utility>

#include <driver/spi_master.h>
#include <esp_timer.h>
#include <freertos/task.h>
#include "biss/catalogue/catalogue.hpp"
#include "embedded/stubs/line.hpp"

extern "C" void app_main();

struct spi_device_t {
  spi_transaction_t* transaction;
};

namespace {

spi_device_t device;
TickType_t ticks = 0;

void expect(bool right) {
  if (!right) std::abort();
}

}  // namespace

void esp_error_check_failed(esp_err_t) { std::abort(); }

esp_err_t spi_bus_initialize(spi_host_device_t host, const spi_bus_config_t* bus,
                             spi_dma_chan_t dma) {
  expect(host == SPI2_HOST && dma == SPI_DMA_CH_AUTO && bus->mosi_io_num == -1);
  return ESP_OK;
}

esp_err_t spi_bus_add_device(spi_host_device_t, const spi_device_interface_config_t* setup,
                             spi_device_handle_t* handle) {
  expect(setup->mode == 3 && setup->spics_io_num == -1 && setup->queue_size == 1);
  *handle = &device;
  return ESP_OK;
}

esp_err_t spi_device_queue_trans(spi_device_handle_t handle, spi_transaction_t* transaction,
                                 TickType_t wait) {
  expect(handle == &device && device.transaction == nullptr && wait == 0);
  expect(transaction->length % 32 == 0);
  device.transaction = transaction;
  return ESP_OK;
}

esp_err_t spi_device_get_trans_result(spi_device_handle_t, spi_transaction_t** transaction,
                                      TickType_t wait) {
  expect(device.transaction != nullptr && wait == portMAX_DELAY);
  *transaction = std::exchange(device.transaction, nullptr);
  // 8 us of ACK at 5 MHz.
  stubs::receive(
      {static_cast<std::uint8_t*>((*transaction)->rx_buffer), (*transaction)->length / 8U},
      biss::catalogue_encoder("resolute-26").frame_format(), 30000000, 40);
  return ESP_OK;
}

std::int64_t esp_timer_get_time() { return ticks * std::int64_t{10'000}; }
TickType_t xTaskGetTickCount() { return ticks; }
void vTaskDelayUntil(TickType_t* woken, TickType_t by) {
  if (stubs::done()) std::exit(0);
  ticks = *woken += by;
}

int main() { app_main(); }
