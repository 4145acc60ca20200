// Reads an encoder with the HAL of an STM32F4: SPI1 with DMA in mode 3. PA5 is MA, PA6 is SLO.
//
// The processor runs at 16 MHz, as after reset, so MA has 4 MHz. For the same without HAL, see
// firmware/boards/stm32f405 of the project.
#include <array>
#include <cstdint>

#include <stm32f4xx_hal.h>
#include "biss/catalogue/catalogue.hpp"
#include "biss/frame/fixed.hpp"
#include "biss/master/spi_read.hpp"

namespace {

constexpr auto encoder = biss::catalogue_encoder("resolute-26");
constexpr biss::SpiSetup setup{.period = biss::period_of(biss::megahertz(4)),
                               .line_delay = {.max = biss::nanoseconds(700)}};
constexpr biss::SpiReader reader(biss::FixedCodec<encoder.frame_format()>{}, setup, encoder.timing);

std::array<std::uint8_t, reader.bytes()> received;
std::array<std::uint8_t, reader.bytes()> ignored;
volatile std::uint32_t position;
volatile std::uint32_t bad_frames;

SPI_HandleTypeDef spi;
DMA_HandleTypeDef receive_dma;
DMA_HandleTypeDef transmit_dma;

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
  HAL_NVIC_EnableIRQ(DMA2_Stream0_IRQn);
  HAL_NVIC_EnableIRQ(DMA2_Stream3_IRQn);
}

}  // namespace

extern "C" void SysTick_Handler() { HAL_IncTick(); }
extern "C" void DMA2_Stream0_IRQHandler() { HAL_DMA_IRQHandler(&receive_dma); }
extern "C" void DMA2_Stream3_IRQHandler() { HAL_DMA_IRQHandler(&transmit_dma); }

extern "C" void HAL_SPI_TxRxCpltCallback(SPI_HandleTypeDef*) {
  const auto frame = reader.read(received);
  if (frame.ok() && frame->trusted()) {
    position = static_cast<std::uint32_t>(frame->channels()[0].position);
  } else {
    bad_frames = bad_frames + 1;  // keep the last position, and stop after some in a row
  }
}

int main() {
  HAL_Init();
  setup_spi();
  for (;;) {
    received.fill(0xFF);  // without bytes from the DMA: no_response, not the last frame
    HAL_SPI_TransmitReceive_DMA(&spi, ignored.data(), received.data(), received.size());
    HAL_Delay(1);  // a control loop uses a timer
  }
}
