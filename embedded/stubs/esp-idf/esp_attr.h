#pragma once
#define DMA_ATTR alignas(4)
