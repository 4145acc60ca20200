// Runs the example of the ESP-IDF component on a PC: four requests, each with a different line.
#include <cstdlib>

#include <driver/spi_master.h>
#include <freertos/task.h>
#include "biss/catalogue/catalogue.hpp"
#include "embedded/stubs/line.hpp"

extern "C" void app_main();

struct spi_device_t {
  spi_device_interface_config_t setup;
};

namespace {

spi_device_t device;
unsigned transfers = 0;

void expect(bool right) {
  if (!right) std::abort();
}

}  // namespace

void esp_error_check_failed(esp_err_t) { std::abort(); }

esp_err_t spi_bus_initialize(spi_host_device_t host, const spi_bus_config_t* bus,
                             spi_dma_chan_t dma) {
  expect(host == SPI2_HOST && dma == SPI_DMA_CH_AUTO && bus->mosi_io_num == -1);
  expect(bus->max_transfer_sz % 4 == 0);
  return ESP_OK;
}

esp_err_t spi_bus_add_device(spi_host_device_t, const spi_device_interface_config_t* setup,
                             spi_device_handle_t* handle) {
  expect(setup->mode == 3 && setup->spics_io_num == -1 && setup->queue_size == 1);
  device.setup = *setup;
  *handle = &device;
  return ESP_OK;
}

esp_err_t spi_device_transmit(spi_device_handle_t handle, spi_transaction_t* transaction) {
  expect(handle == &device && transaction->length % 32 == 0);
  constexpr stubs::LineFault faults[] = {stubs::LineFault::none, stubs::LineFault::no_response,
                                         stubs::LineFault::crc, stubs::LineFault::error_bit};
  const std::span bytes(static_cast<std::uint8_t*>(transaction->rx_buffer),
                        transaction->length / 8U);
  // 8 us of ACK at 5 MHz.
  stubs::receive(bytes, biss::catalogue_encoder("resolute-26").frame_format(),
                 30000000U + transfers, 40, faults[transfers]);
  ++transfers;
  return ESP_OK;
}

void vTaskDelay(TickType_t) {
  if (transfers == 4) std::exit(0);
}

int main() { app_main(); }
