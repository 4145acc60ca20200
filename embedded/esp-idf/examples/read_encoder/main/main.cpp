// Reads an encoder with the SPI master driver of ESP-IDF: SPI2 with DMA in mode 3, 5 MHz.
#include <algorithm>
#include <cinttypes>
#include <cstdint>
#include <iterator>
#include <span>

#include <driver/spi_master.h>
#include <esp_attr.h>
#include <esp_log.h>
#include <freertos/FreeRTOS.h>
#include <freertos/task.h>
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/spi_read.hpp"

namespace {

constexpr const char* tag = "encoder";
constexpr int pin_ma = 12;   // SCK
constexpr int pin_slo = 13;  // MISO
constexpr int clock_hz = 5'000'000;

constexpr auto encoder = biss::catalogue_encoder("resolute-26");
constexpr biss::SpiSetup setup{.period = biss::period_of(biss::hertz(clock_hz)),
                               .line_delay = {.max = biss::nanoseconds(700)}};
constexpr biss::SpiReader reader(biss::FixedCodec<encoder.frame_format()>{}, setup, encoder.timing);

// The DMA writes whole words.
constexpr std::size_t transfer_bytes = (reader.bytes() + 3U) / 4U * 4U;
DMA_ATTR std::uint8_t received[transfer_bytes];

spi_device_handle_t open_spi() {
  spi_bus_config_t bus{};
  bus.mosi_io_num = -1;
  bus.miso_io_num = pin_slo;
  bus.sclk_io_num = pin_ma;
  bus.quadwp_io_num = -1;
  bus.quadhd_io_num = -1;
  bus.max_transfer_sz = transfer_bytes;
  ESP_ERROR_CHECK(spi_bus_initialize(SPI2_HOST, &bus, SPI_DMA_CH_AUTO));

  spi_device_interface_config_t device{};
  device.mode = 3;  // idle high, sampled at the rising edge
  device.clock_speed_hz = clock_hz;
  device.spics_io_num = -1;
  device.queue_size = 1;
  spi_device_handle_t spi = nullptr;
  ESP_ERROR_CHECK(spi_bus_add_device(SPI2_HOST, &device, &spi));
  return spi;
}

bool transfer(spi_device_handle_t spi) {
  spi_transaction_t transaction{};
  transaction.length = transfer_bytes * 8U;
  transaction.rx_buffer = received;
  // If the DMA writes nothing, the result is no_response and not the last frame.
  std::fill(std::begin(received), std::end(received), std::uint8_t{0xFF});
  return spi_device_transmit(spi, &transaction) == ESP_OK;
}

}  // namespace

extern "C" void app_main() {
  const spi_device_handle_t spi = open_spi();
  for (;;) {
    vTaskDelay(pdMS_TO_TICKS(100));
    if (!transfer(spi)) {
      ESP_LOGE(tag, "no transfer");
      continue;
    }
    const auto frame = reader.read(std::span<const std::uint8_t>(received));
    if (!frame.ok()) {
      ESP_LOGW(tag, "%s", name_of(frame.error().cause).data());
    } else if (!frame->trusted()) {
      ESP_LOGW(tag, "the encoder reports an error");
    } else {
      ESP_LOGI(tag, "position %" PRIu64, frame->channels()[0].position);
    }
  }
}
