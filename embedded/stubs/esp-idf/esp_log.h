#pragma once
#include <cstdio>
#define ESP_LOGI(tag, format, ...) std::printf("I %s: " format "\n", tag, ##__VA_ARGS__)
#define ESP_LOGW(tag, format, ...) std::printf("W %s: " format "\n", tag, ##__VA_ARGS__)
#define ESP_LOGE(tag, format, ...) std::printf("E %s: " format "\n", tag, ##__VA_ARGS__)
