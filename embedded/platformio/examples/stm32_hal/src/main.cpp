// Reads an encoder with the HAL of an STM32F4: SPI1 with DMA in mode 3. PA5 is MA, PA6 is SLO.
//
// The processor runs at 16 MHz, as after reset, so MA has 4 MHz. For the same without HAL, see
// firmware/boards/stm32f405 of the project.
#include <cstdint>
#include <span>

#include <stm32f4xx_hal.h>
#include "biss/axis/encoder_axis.hpp"
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/spi_read.hpp"

namespace {

constexpr auto encoder = biss::catalogue_encoder("resolute-26");
constexpr biss::SpiSetup line{.period = biss::period_of(biss::megahertz(4)),
                              .line_delay = {.max = biss::nanoseconds(700)}};
constexpr biss::SpiReader reader(biss::FixedCodec<encoder.frame_format()>{}, line, encoder.timing);
constexpr biss::AxisSetup limits{.cycle = biss::milliseconds(1),
                                 .to_sampling = biss::sampling_delay(line, encoder.timing),
                                 .max_step = 3'800'000};  // 3000 turns per minute of 2^26 counts

SPI_HandleTypeDef spi;
DMA_HandleTypeDef receive_dma;
DMA_HandleTypeDef transmit_dma;

struct Spi {
  bool start(std::span<std::uint8_t> receive) {
    // MOSI is not connected, so the bytes that are sent do not matter.
    const auto size = static_cast<std::uint16_t>(receive.size());
    return HAL_SPI_TransmitReceive_DMA(&spi, receive.data(), receive.data(), size) == HAL_OK;
  }
};

Spi transfer;
constinit biss::EncoderAxis<Spi, decltype(reader), reader.bytes()> axis{transfer, reader, limits};
biss::Picoseconds clock_time;
// For the control loop.
volatile std::int64_t position;
volatile biss::AxisState state;

void setup_stream(DMA_HandleTypeDef& dma, DMA_Stream_TypeDef* stream, std::uint32_t direction,
                  std::uint32_t priority) {
  dma.Instance = stream;
  dma.Init.Channel = DMA_CHANNEL_3;
  dma.Init.Direction = direction;
  dma.Init.PeriphInc = DMA_PINC_DISABLE;
  dma.Init.MemInc = DMA_MINC_ENABLE;
  dma.Init.PeriphDataAlignment = DMA_PDATAALIGN_BYTE;
  dma.Init.MemDataAlignment = DMA_MDATAALIGN_BYTE;
  dma.Init.Mode = DMA_NORMAL;
  dma.Init.Priority = priority;
  dma.Init.FIFOMode = DMA_FIFOMODE_DISABLE;
  HAL_DMA_Init(&dma);
}

void setup_spi() {
  __HAL_RCC_GPIOA_CLK_ENABLE();
  __HAL_RCC_SPI1_CLK_ENABLE();
  __HAL_RCC_DMA2_CLK_ENABLE();
  GPIO_InitTypeDef pins{};
  pins.Pin = GPIO_PIN_5 | GPIO_PIN_6;
  pins.Mode = GPIO_MODE_AF_PP;
  pins.Pull = GPIO_PULLUP;
  pins.Speed = GPIO_SPEED_FREQ_HIGH;
  pins.Alternate = GPIO_AF5_SPI1;
  HAL_GPIO_Init(GPIOA, &pins);

  spi.Instance = SPI1;
  spi.Init.Mode = SPI_MODE_MASTER;
  spi.Init.Direction = SPI_DIRECTION_2LINES;
  spi.Init.DataSize = SPI_DATASIZE_8BIT;
  spi.Init.CLKPolarity = SPI_POLARITY_HIGH;
  spi.Init.CLKPhase = SPI_PHASE_2EDGE;
  spi.Init.NSS = SPI_NSS_SOFT;
  spi.Init.BaudRatePrescaler = SPI_BAUDRATEPRESCALER_4;
  spi.Init.FirstBit = SPI_FIRSTBIT_MSB;
  HAL_SPI_Init(&spi);
  __HAL_SPI_ENABLE(&spi);  // SCK is driven high from here on

  setup_stream(receive_dma, DMA2_Stream0, DMA_PERIPH_TO_MEMORY, DMA_PRIORITY_VERY_HIGH);
  setup_stream(transmit_dma, DMA2_Stream3, DMA_MEMORY_TO_PERIPH, DMA_PRIORITY_HIGH);
  __HAL_LINKDMA(&spi, hdmarx, receive_dma);
  __HAL_LINKDMA(&spi, hdmatx, transmit_dma);
  // The priority of SysTick, so that no interrupt of the axis interrupts another one.
  HAL_NVIC_SetPriority(DMA2_Stream0_IRQn, TICK_INT_PRIORITY, 0);
  HAL_NVIC_SetPriority(DMA2_Stream3_IRQn, TICK_INT_PRIORITY, 0);
  HAL_NVIC_EnableIRQ(DMA2_Stream0_IRQn);
  HAL_NVIC_EnableIRQ(DMA2_Stream3_IRQn);
}

}  // namespace

// The control interrupt. A machine takes the time from a timer, which also counts the interrupts
// that are lost.
extern "C" void SysTick_Handler() {
  HAL_IncTick();
  const biss::AxisPosition now = axis.position();
  position = now.position;
  state = now.state;
  clock_time = biss::wrapping_later(clock_time, limits.cycle);
  axis.request(clock_time);
}
extern "C" void DMA2_Stream0_IRQHandler() { HAL_DMA_IRQHandler(&receive_dma); }
extern "C" void DMA2_Stream3_IRQHandler() { HAL_DMA_IRQHandler(&transmit_dma); }
extern "C" void HAL_SPI_TxRxCpltCallback(SPI_HandleTypeDef*) { axis.transfer_complete(); }
extern "C" void HAL_SPI_ErrorCallback(SPI_HandleTypeDef*) { axis.transfer_failed(); }

int main() {
  HAL_Init();
  setup_spi();
  for (;;) __WFI();
}
