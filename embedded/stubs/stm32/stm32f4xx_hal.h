// The parts of ST's HAL for the STM32F4 that the example uses (user manual UM1725).
#pragma once

#include <cstdint>

enum HAL_StatusTypeDef { HAL_OK = 0 };
enum IRQn_Type { DMA2_Stream0_IRQn = 56, DMA2_Stream3_IRQn = 59 };

struct GPIO_TypeDef;
struct SPI_TypeDef;
struct DMA_Stream_TypeDef;
extern GPIO_TypeDef* const GPIOA;
extern SPI_TypeDef* const SPI1;
extern DMA_Stream_TypeDef* const DMA2_Stream0;
extern DMA_Stream_TypeDef* const DMA2_Stream3;

struct GPIO_InitTypeDef {
  std::uint32_t Pin, Mode, Pull, Speed, Alternate;
};
struct SPI_InitTypeDef {
  std::uint32_t Mode, Direction, DataSize, CLKPolarity, CLKPhase, NSS, BaudRatePrescaler, FirstBit;
};
struct DMA_InitTypeDef {
  std::uint32_t Channel, Direction, PeriphInc, MemInc, PeriphDataAlignment, MemDataAlignment, Mode,
      Priority, FIFOMode;
};
struct DMA_HandleTypeDef {
  DMA_Stream_TypeDef* Instance;
  DMA_InitTypeDef Init;
  void* Parent;
};
struct SPI_HandleTypeDef {
  SPI_TypeDef* Instance;
  SPI_InitTypeDef Init;
  DMA_HandleTypeDef* hdmatx;
  DMA_HandleTypeDef* hdmarx;
};

inline constexpr std::uint32_t GPIO_PIN_5 = 1U << 5U, GPIO_PIN_6 = 1U << 6U, GPIO_MODE_AF_PP = 2,
                               GPIO_PULLUP = 1, GPIO_SPEED_FREQ_HIGH = 2, GPIO_AF5_SPI1 = 5,
                               SPI_MODE_MASTER = 0x104, SPI_DIRECTION_2LINES = 0,
                               SPI_DATASIZE_8BIT = 0, SPI_POLARITY_HIGH = 2, SPI_PHASE_2EDGE = 1,
                               SPI_NSS_SOFT = 0x200, SPI_BAUDRATEPRESCALER_4 = 8,
                               SPI_FIRSTBIT_MSB = 0, DMA_CHANNEL_3 = 3U << 25U,
                               DMA_PERIPH_TO_MEMORY = 0, DMA_MEMORY_TO_PERIPH = 0x40,
                               DMA_PINC_DISABLE = 0, DMA_MINC_ENABLE = 0x400,
                               DMA_PDATAALIGN_BYTE = 0, DMA_MDATAALIGN_BYTE = 0, DMA_NORMAL = 0,
                               DMA_PRIORITY_HIGH = 0x20000, DMA_PRIORITY_VERY_HIGH = 0x30000,
                               DMA_FIFOMODE_DISABLE = 0, TICK_INT_PRIORITY = 15;

#define __WFI() static_cast<void>(0)
#define __HAL_RCC_GPIOA_CLK_ENABLE() static_cast<void>(0)
#define __HAL_RCC_SPI1_CLK_ENABLE() static_cast<void>(0)
#define __HAL_RCC_DMA2_CLK_ENABLE() static_cast<void>(0)
#define __HAL_SPI_ENABLE(handle) static_cast<void>(handle)
#define __HAL_LINKDMA(handle, field, dma) \
  do {                                    \
    (handle)->field = &(dma);             \
    (dma).Parent = (handle);              \
  } while (0)

extern "C" {
HAL_StatusTypeDef HAL_Init();
void HAL_IncTick();
void HAL_GPIO_Init(GPIO_TypeDef* port, GPIO_InitTypeDef* init);
HAL_StatusTypeDef HAL_SPI_Init(SPI_HandleTypeDef* spi);
HAL_StatusTypeDef HAL_SPI_TransmitReceive_DMA(SPI_HandleTypeDef* spi, const std::uint8_t* transmit,
                                              std::uint8_t* receive, std::uint16_t size);
void HAL_SPI_TxRxCpltCallback(SPI_HandleTypeDef* spi);
void HAL_SPI_ErrorCallback(SPI_HandleTypeDef* spi);
HAL_StatusTypeDef HAL_DMA_Init(DMA_HandleTypeDef* dma);
void HAL_DMA_IRQHandler(DMA_HandleTypeDef* dma);
void HAL_NVIC_SetPriority(IRQn_Type number, std::uint32_t preempt, std::uint32_t sub);
void HAL_NVIC_EnableIRQ(IRQn_Type number);
}
