// The functions of the sensor driver: the axis of the core, read with transfers of Zephyr.
#include <biss_zephyr/driver.h>

#include <errno.h>

#include <cstddef>
#include <iterator>
#include <new>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include <zephyr/logging/log.h>

#include <biss_zephyr/encoder.h>

#include "biss/axis/encoder_axis.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

LOG_MODULE_REGISTER(biss_encoder, CONFIG_SENSOR_LOG_LEVEL);

namespace {

using Config = biss_encoder_config;
using Data = biss_encoder_data;

// The longest timeout of an encoder: between two requests of a fetch.
constexpr std::uint32_t timeout_us = 40;

// Transfers in start().
struct Spi {
  const spi_dt_spec* spec;
  int result = 0;

  bool start(std::span<std::uint8_t> receive) {
    const spi_buf buffer{.buf = receive.data(), .len = receive.size()};
    const spi_buf_set buffers{.buffers = &buffer, .count = 1};
    result = spi_read_dt(spec, &buffers);
    return true;
  }
};

struct Encoder {
  using Codec = biss::FrameCodec<biss::CrcTable<4>, 1>;
  using Reader = biss::SpiReader<Codec>;

  Spi spi;
  Reader reader;
  biss::AxisSetup setup;
  biss::EncoderAxis<Spi, Reader, CONFIG_BISS_ENCODER_BYTES> axis{spi, reader, setup};
};
static_assert(sizeof(Encoder) <= sizeof(Data::axis) && alignof(Encoder) <= alignof(std::uint64_t));
static_assert(std::is_trivially_destructible_v<Encoder>);

int error_of(biss::AxisCause cause) {
  // In the order of AxisCause, up to `early`. The other ones need a further request.
  constexpr int errors[] = {0,       -ENODEV, -EBUSY,   -ERANGE,  -ERANGE,
                            -ERANGE, -ERANGE, -EBADMSG, -EBADMSG, -EBADMSG,
                            -EFAULT, -EAGAIN, -EDOM,    0,        0};
  static_assert(std::size(errors) == biss::index_of(biss::AxisCause::early) + 1);
  return biss::index_of(cause) < std::size(errors) ? errors[biss::index_of(cause)] : -EAGAIN;
}

// \return the bytes of a transfer; empty if the format or a limit is not valid, or if the format
// lacks nE or CRC and the node does not permit this
std::optional<std::size_t> make_encoder(const Config& config, Data& data) {
  const auto format = biss::parse_format(std::string_view(config.frame_format));
  const std::uint32_t clock_hz = config.spi.config.frequency;
  if (!format.ok() || format->channel_count != 1 || clock_hz == 0 || config.rotation_bits > 32) {
    return std::nullopt;
  }
  const biss::SpiSetup line{.period = biss::period_of(biss::hertz(clock_hz)),
                            .line_delay = {.max = biss::nanoseconds(config.line_delay_max_ns)},
                            .no_error_flag = config.no_error_flag,
                            .unchecked = config.unchecked};
  const biss::DeviceTiming timing{.ack_max = biss::nanoseconds(config.processing_time_max_ns)};
  if (timing.ack_max > biss::biss_busy_max || line.line_delay.max > biss::biss_line_delay_max) {
    return std::nullopt;
  }
  // Each bad frame trips, and the next fetch starts again.
  const biss::AxisSetup limits{
      .cycle = biss::axis_cycle_max,
      .to_sampling = biss::sampling_delay(line, timing),
      .max_step = config.max_step == 0 ? biss::no_step_limit : config.max_step,
      .bad_cycles = biss::BadCycleRule::trip,
      .power_up = {}};
  const auto* encoder =
      new (data.axis) Encoder{{&config.spi}, {Encoder::Codec(*format), line, timing}, limits};
  const auto error = encoder->axis.error();
  if (error && *error != biss::AxisError::buffer) return std::nullopt;
  return encoder->reader.bytes();
}

// Requests a position. \return 0, or an error of biss_zephyr/encoder.h; -EAGAIN: call it again after
// the encoder's timeout, because a position needs two frames that agree
int request(Data& data) {
  auto& encoder = *std::launder(reinterpret_cast<Encoder*>(data.axis));
  auto& axis = encoder.axis;
  if (axis.position().state == biss::AxisState::tripped) axis.reset();
  // Wraps around after 106 days.
  const std::uint64_t time = static_cast<std::uint64_t>(k_uptime_get()) * 1'000'000'000U;
  axis.request(biss::Picoseconds{static_cast<std::int64_t>(time)});
  if (encoder.spi.result != 0) {
    axis.transfer_failed();
    return encoder.spi.result;
  }
  axis.transfer_complete();
  const biss::AxisPosition position = axis.position();
  if (const int error = error_of(position.cause); error != 0) return error;
  const unsigned bits = encoder.reader.codec().format().channel_list[0].position_bits();
  data.position = static_cast<std::uint64_t>(position.position) & biss::low_mask(bits);
  data.warning = position.cause == biss::AxisCause::warning;
  data.line_delay_clocks = axis.line_delay_seen()->second;
  data.fetched = true;
  return 0;
}

// A channel of the last good fetch. \pre the lock is held
int get(const Config& config, const Data& data, int chan, sensor_value& value) {
  if (!data.fetched) return -ENODATA;
  switch (chan) {
    case SENSOR_CHAN_ROTATION: {
      if (config.rotation_bits == 0) return -ENOTSUP;
      // The angle of the position within its rotation, in degrees and millionths of a degree.
      const std::uint64_t count = data.position & biss::low_mask(config.rotation_bits);
      const std::uint64_t millionths = (count * 360'000'000U) >> config.rotation_bits;
      value = {static_cast<std::int32_t>(millionths / 1'000'000U),
               static_cast<std::int32_t>(millionths % 1'000'000U)};
      return 0;
    }
    case SENSOR_CHAN_BISS_POSITION:
      value = {static_cast<std::int32_t>(data.position >> 32U),
               static_cast<std::int32_t>(data.position)};
      return 0;
    case SENSOR_CHAN_BISS_WARNING:
      value = {data.warning, 0};
      return 0;
    case SENSOR_CHAN_BISS_LINE_DELAY:
      value = {data.line_delay_clocks, 0};
      return 0;
    default:
      return -ENOTSUP;
  }
}

}  // namespace

int biss_encoder_init(const device* dev) {
  const auto& config = *static_cast<const Config*>(dev->config);
  auto& data = *static_cast<Data*>(dev->data);
  k_mutex_init(&data.lock);
  if (!spi_is_ready_dt(&config.spi)) {
    LOG_ERR("%s: the SPI controller is not ready", dev->name);
    return -ENODEV;
  }
  const auto bytes = make_encoder(config, data);
  if (!bytes) {
    LOG_ERR("%s: biss-format \"%s\" or a limit is not valid, or lacks nE or CRC", dev->name,
            config.frame_format);
    return -EINVAL;
  }
  if (*bytes > CONFIG_BISS_ENCODER_BYTES) {
    LOG_ERR("%s: needs BISS_ENCODER_BYTES=%d", dev->name, static_cast<int>(*bytes));
    return -ENOMEM;
  }
  return 0;
}

int biss_encoder_fetch(const device* dev, sensor_channel chan) {
  if (chan != SENSOR_CHAN_ALL && chan != SENSOR_CHAN_ROTATION &&
      static_cast<int>(chan) != SENSOR_CHAN_BISS_POSITION) {
    return -ENOTSUP;
  }
  auto& data = *static_cast<Data*>(dev->data);
  k_mutex_lock(&data.lock, K_FOREVER);
  int result = request(data);
  for (int further = 2; result == -EAGAIN && further > 0; --further) {
    k_busy_wait(timeout_us);
    result = request(data);
  }
  k_mutex_unlock(&data.lock);
  return result;
}

int biss_encoder_get(const device* dev, sensor_channel chan, sensor_value* value) {
  auto& data = *static_cast<Data*>(dev->data);
  k_mutex_lock(&data.lock, K_FOREVER);
  const int result = get(*static_cast<const Config*>(dev->config), data, chan, *value);
  k_mutex_unlock(&data.lock);
  return result;
}
