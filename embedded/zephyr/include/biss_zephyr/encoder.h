/* Channels of the BiSS C encoder driver, besides SENSOR_CHAN_ROTATION.
 *
 * sensor_sample_fetch() requests one position. It returns 0 only for a frame with a good CRC whose
 * encoder reports no error; the channels then hold this frame. Otherwise it keeps the last one:
 *
 *   -ENODEV   no_response: no encoder answers
 *   -EBUSY    not_ready: the request came before the timeout was over, or SLO is stuck low
 *   -EBADMSG  crc, cds, stop_bit: the frame was disturbed on the line
 *   -ERANGE   response_range, ack_range, no_start, truncated: another encoder, or other limits
 *   -EFAULT   the frame is good, and the encoder reports an error (nE = 0)
 *   others    of spi_transceive()
 */
#pragma once

#include <zephyr/drivers/sensor.h>

enum biss_encoder_channel {
  /* The position in counts: val1 holds its upper, val2 its lower 32 bits. */
  SENSOR_CHAN_BISS_POSITION = SENSOR_CHAN_PRIV_START,
  /* val1 = 1: the encoder reports a warning (nW = 0). The position is valid. */
  SENSOR_CHAN_BISS_WARNING,
  /* Whole clocks of line delay in val1. */
  SENSOR_CHAN_BISS_LINE_DELAY,
};
