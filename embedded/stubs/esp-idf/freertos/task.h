#pragma once
#include <freertos/FreeRTOS.h>
TickType_t xTaskGetTickCount();
void vTaskDelayUntil(TickType_t* woken, TickType_t ticks);
