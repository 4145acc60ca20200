/* Prints the angle of a BiSS C encoder ten times a second. */
#include <zephyr/device.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

int main(void) {
  const struct device* const encoder = DEVICE_DT_GET(DT_NODELABEL(encoder));
  struct sensor_value angle;
  int result;

  if (!device_is_ready(encoder)) {
    printk("The encoder is not ready\n");
    return 0;
  }
  for (;;) {
    k_msleep(100);
    result = sensor_sample_fetch(encoder);
    if (result == 0) {
      result = sensor_channel_get(encoder, SENSOR_CHAN_ROTATION, &angle);
    }
    if (result != 0) {
      printk("no position: %d\n", result);
      continue;
    }
    printk("%d.%06d degrees\n", angle.val1, angle.val2);
  }
}
