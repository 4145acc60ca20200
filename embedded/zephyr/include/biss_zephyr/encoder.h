/* Channels of the BiSS C encoder driver, besides SENSOR_CHAN_ROTATION.
 *
 * sensor_sample_fetch() requests one position. The first position, and each one after an error or
 * after 100 s without a fetch, needs two frames that agree: the fetch then makes a request or two
 * more, 40 us later. It returns 0 only for a frame with a good CRC whose encoder reports no error;
 * the channels then hold this frame. Otherwise they keep the last one, and the result is
 *
 *   -ENODEV   no_response: no encoder answers
 *   -EBUSY    not_ready: the request came before the timeout was over, or SLO is stuck low
 *   -EBADMSG  crc, cds, stop_bit: the frame was disturbed on the line
 *   -ERANGE   response_range, ack_range, no_start, truncated: another encoder, or other limits
 *   -EFAULT   error_bit: the frame is good, and the encoder reports an error (nE = 0)
 *   -EDOM     step: the position is farther from the last one than max-step, or the frames differ
 *   others    of spi_transceive()
 */
#pragma once

#include <zephyr/drivers/sensor.h>

enum biss_encoder_channel {
  /* The position in counts: val1 holds its upper, val2 its lower 32 bits. */
  SENSOR_CHAN_BISS_POSITION = SENSOR_CHAN_PRIV_START,
  /* val1 = 1: the encoder reports a warning (nW = 0). The position is valid. */
  SENSOR_CHAN_BISS_WARNING,
  /* val1: the longest line delay since the last error, in whole clocks. */
  SENSOR_CHAN_BISS_LINE_DELAY,
};
