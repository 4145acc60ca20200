#pragma once
#include <cstdint>
using TickType_t = std::uint32_t;
#define pdMS_TO_TICKS(milliseconds) (static_cast<TickType_t>(milliseconds) / 10U)
inline constexpr TickType_t portMAX_DELAY = 0xFFFFFFFF;
