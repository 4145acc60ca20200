// Reads an encoder with the SPI master driver of ESP-IDF: SPI2 with DMA in mode 3, 5 MHz.
#include <cinttypes>
#include <cstdint>
#include <span>

#include <driver/spi_master.h>
#include <esp_attr.h>
#include <esp_log.h>
#include <esp_timer.h>
#include <freertos/FreeRTOS.h>
#include <freertos/task.h>
#include "biss/axis/encoder_axis.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/spi_read.hpp"

namespace {

constexpr const char* tag = "encoder";
constexpr int pin_ma = 12;   // SCK
constexpr int pin_slo = 13;  // MISO
constexpr int clock_hz = 5'000'000;

constexpr auto encoder = biss::catalogue_encoder("resolute-26");
constexpr biss::SpiSetup line{.period = biss::period_of(biss::hertz(clock_hz)),
                              .line_delay = {.max = biss::nanoseconds(700)}};
constexpr biss::SpiReader reader(biss::FixedCodec<encoder.frame_format()>{}, line, encoder.timing);
constexpr biss::AxisSetup limits{.cycle = biss::milliseconds(10),
                                 .to_sampling = biss::sampling_delay(line, encoder.timing),
                                 .max_step = 4'000'000};  // 300 turns per minute of 2^26 counts

struct Spi {
  spi_device_handle_t device{};
  spi_transaction_t transaction{};

  bool start(std::span<std::uint8_t> receive) {
    // The DMA writes whole words. A buffer of the axis ends with a whole word.
    transaction.length = (receive.size() + 3U) / 4U * 32U;
    transaction.rx_buffer = receive.data();
    return spi_device_queue_trans(device, &transaction, 0) == ESP_OK;
  }
  bool end() {
    spi_transaction_t* ended = nullptr;
    return spi_device_get_trans_result(device, &ended, portMAX_DELAY) == ESP_OK;
  }
};

Spi spi;
DMA_ATTR biss::EncoderAxis<Spi, decltype(reader), reader.bytes()> axis(spi, reader, limits);

// Wraps around after 106 days.
biss::Picoseconds clock_time() {
  const auto microseconds = static_cast<std::uint64_t>(esp_timer_get_time());
  return biss::Picoseconds{static_cast<std::int64_t>(microseconds * 1'000'000U)};
}

void open_spi() {
  spi_bus_config_t bus{};
  bus.mosi_io_num = -1;
  bus.miso_io_num = pin_slo;
  bus.sclk_io_num = pin_ma;
  bus.quadwp_io_num = -1;
  bus.quadhd_io_num = -1;
  ESP_ERROR_CHECK(spi_bus_initialize(SPI2_HOST, &bus, SPI_DMA_CH_AUTO));

  spi_device_interface_config_t device{};
  device.mode = 3;  // idle high, sampled at the rising edge
  device.clock_speed_hz = clock_hz;
  device.spics_io_num = -1;
  device.queue_size = 1;
  ESP_ERROR_CHECK(spi_bus_add_device(SPI2_HOST, &device, &spi.device));
}

}  // namespace

extern "C" void app_main() {
  open_spi();
  for (TickType_t woken = xTaskGetTickCount();;) {
    axis.request(clock_time());
    vTaskDelayUntil(&woken, pdMS_TO_TICKS(10));
    // One task requests and ends, so that the axis needs no lock.
    if (axis.waits() && spi.end()) axis.transfer_complete();
    const biss::AxisPosition now = axis.position();
    if (now.state == biss::AxisState::measured) {
      ESP_LOGI(tag, "position %" PRId64, now.position);
    } else {
      ESP_LOGW(tag, "%s: %s", name_of(now.state).data(), name_of(now.cause).data());
    }
    // A machine stops here. The turns start from 0 again.
    if (now.state == biss::AxisState::tripped) axis.reset();
  }
}
