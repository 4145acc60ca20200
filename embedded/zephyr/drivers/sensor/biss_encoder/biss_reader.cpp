// The axis of the core for the driver, which is in C.
#include <biss_zephyr/reader.h>

#include <errno.h>

#include <cstddef>
#include <iterator>
#include <new>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/axis/encoder_axis.hpp"
#include "biss/base/bits.hpp"
#include "biss/base/units.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

namespace {

// Transfers in start().
struct Spi {
  biss_transfer transfer;
  const void* context;
  int result = 0;

  bool start(std::span<std::uint8_t> receive) {
    result = transfer(context, receive.data(), receive.size());
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
static_assert(sizeof(Encoder) <= sizeof(biss_reader) && alignof(Encoder) <= alignof(biss_reader));
static_assert(std::is_trivially_destructible_v<Encoder>);

int error_of(biss::AxisCause cause) {
  // In the order of AxisCause, up to `warning`. The other ones need a further request.
  constexpr int errors[] = {0,        -ENODEV,  -EBUSY,   -ERANGE, -ERANGE, -ERANGE, -ERANGE,
                            -EBADMSG, -EBADMSG, -EBADMSG, -EFAULT, -EAGAIN, -EDOM,   0};
  static_assert(std::size(errors) == biss::index_of(biss::AxisCause::warning) + 1);
  return biss::index_of(cause) < std::size(errors) ? errors[biss::index_of(cause)] : -EAGAIN;
}

}  // namespace

int biss_reader_init(biss_reader* reader, const biss_reader_setup* setup, biss_transfer transfer,
                     const void* context) {
  const auto format = biss::parse_format(std::string_view(setup->frame_format));
  if (!format.ok() || format->channel_count != 1 || setup->clock_hz == 0) return -EINVAL;
  const biss::SpiSetup line{.period = biss::period_of(biss::hertz(setup->clock_hz)),
                            .line_delay = {.max = biss::nanoseconds(setup->line_delay_max_ns)},
                            .no_error_flag = setup->no_error_flag,
                            .unchecked = setup->unchecked};
  const biss::DeviceTiming timing{.ack_max = biss::nanoseconds(setup->processing_time_max_ns)};
  if (timing.ack_max > biss::biss_busy_max || line.line_delay.max > biss::biss_line_delay_max) {
    return -EINVAL;
  }
  // Each bad frame trips, and the next fetch starts again.
  const biss::AxisSetup limits{
      .cycle = biss::axis_cycle_max,
      .to_sampling = biss::sampling_delay(line, timing),
      .max_step = setup->max_step == 0 ? biss::no_step_limit : setup->max_step,
      .bad_cycles = biss::BadCycleRule::trip,
      .power_up = {}};
  const auto* encoder = new (reader->storage)
      Encoder{{transfer, context}, {Encoder::Codec(*format), line, timing}, limits};
  const auto error = encoder->axis.error();
  if (error && *error != biss::AxisError::buffer) return -EINVAL;
  return static_cast<int>(encoder->reader.bytes());
}

int biss_reader_fetch(biss_reader* reader, std::int64_t uptime_ms, biss_sample* sample) {
  auto& encoder = *std::launder(reinterpret_cast<Encoder*>(reader->storage));
  auto& axis = encoder.axis;
  if (axis.position().state == biss::AxisState::tripped) axis.reset();
  // Wraps around after 106 days.
  const std::uint64_t time = static_cast<std::uint64_t>(uptime_ms) * 1'000'000'000U;
  axis.request(biss::Picoseconds{static_cast<std::int64_t>(time)});
  if (encoder.spi.result != 0) {
    axis.transfer_failed();
    return encoder.spi.result;
  }
  axis.transfer_complete();
  const biss::AxisPosition position = axis.position();
  if (const int error = error_of(position.cause); error != 0) return error;
  const unsigned bits = encoder.reader.codec().format().channel_list[0].position_bits();
  sample->position = static_cast<std::uint64_t>(position.position) & biss::low_mask(bits);
  sample->warning = position.cause == biss::AxisCause::warning;
  sample->line_delay_clocks = axis.line_delay_seen()->second;
  return 0;
}
