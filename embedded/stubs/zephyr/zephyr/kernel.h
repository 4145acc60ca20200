#pragma once
#include <zephyr/device.h>
struct k_mutex {
  int count;
};
#define K_FOREVER (-1)
int k_mutex_init(struct k_mutex* mutex);
int k_mutex_lock(struct k_mutex* mutex, int timeout);
int k_mutex_unlock(struct k_mutex* mutex);
int32_t k_msleep(int32_t milliseconds);
int64_t k_uptime_get(void);
void k_busy_wait(uint32_t microseconds);
