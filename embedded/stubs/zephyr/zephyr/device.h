/* Zephyr's device model with one instance of one driver, on a PC. The instance is what a devicetree
 * with the node of the test describes. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct device {
  const char* name;
  const void* config;
  const void* api;
  void* data;
  int (*init)(const struct device* dev);
};

extern const struct device biss_test_encoder;
#define DT_NODELABEL(label) label
#define DEVICE_DT_GET_(node) (&biss_test_##node)
#define DEVICE_DT_GET(node) DEVICE_DT_GET_(node)
bool device_is_ready(const struct device* dev);

/* The node: the test's properties. */
#define DT_INST_PROP(inst, name) DT_TEST_##name
#define DT_INST_PROP_OR(inst, name, otherwise) DT_TEST_##name
#define DT_INST_FOREACH_STATUS_OKAY(define) define(0)
#define DT_TEST_biss_format "pos18,nE,nW,crc6"
#define DT_TEST_spi_max_frequency 4000000
#define DT_TEST_line_delay_max_ns 1000
#define DT_TEST_processing_time_max_ns 10000
#define DT_TEST_rotation_bits 18
#define DT_TEST_max_step 1000
#define DT_TEST_no_error_flag false
#define DT_TEST_unchecked false
