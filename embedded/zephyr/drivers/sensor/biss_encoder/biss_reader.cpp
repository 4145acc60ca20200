// The SpiReader of the core for the driver, which is in C.
#include <biss_zephyr/reader.h>

#include <errno.h>

#include <cstddef>
#include <new>
#include <span>
#include <string_view>
#include <type_traits>

#include "biss/base/units.hpp"
#include "biss/crc/engines.hpp"
#include "biss/frame/codec.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/frame/frame.hpp"
#include "biss/master/spi_read.hpp"
#include "biss/timing/device_timing.hpp"

namespace {

using Codec = biss::FrameCodec<biss::CrcTable<4>, 1>;
using Reader = biss::SpiReader<Codec>;
static_assert(sizeof(Reader) <= BISS_READER_BYTES && alignof(Reader) <= alignof(biss_reader));
static_assert(std::is_trivially_destructible_v<Reader>);

int error_of(biss::FrameError cause) {
  switch (cause) {
    case biss::FrameError::no_response:
      return -ENODEV;
    case biss::FrameError::not_ready:
      return -EBUSY;
    case biss::FrameError::cds:
    case biss::FrameError::crc:
    case biss::FrameError::stop_bit:
      return -EBADMSG;
    case biss::FrameError::response_range:
    case biss::FrameError::no_start:
    case biss::FrameError::ack_range:
    case biss::FrameError::truncated:
      return -ERANGE;
  }
  return -ERANGE;
}

}  // namespace

int biss_reader_init(biss_reader* reader, const biss_reader_setup* setup) {
  const auto format = biss::parse_format(std::string_view(setup->frame_format));
  if (!format.ok() || format->channel_count != 1) return -EINVAL;
  if (format->channel_list[0].position_bits() == 0 || setup->clock_hz == 0) return -EINVAL;
  const biss::SpiSetup spi{.period = biss::period_of(biss::hertz(setup->clock_hz)),
                           .line_delay = {.max = biss::nanoseconds(setup->line_delay_max_ns)},
                           .no_error_flag = setup->no_error_flag,
                           .unchecked = setup->unchecked};
  const biss::DeviceTiming timing{.ack_max = biss::nanoseconds(setup->processing_time_max_ns)};
  if (timing.ack_max > biss::biss_busy_max || spi.line_delay.max > biss::biss_line_delay_max) {
    return -EINVAL;
  }
  if (biss::check_spi(*format, spi, timing)) return -EINVAL;
  const auto* made = new (reader->storage) Reader(Codec(*format), spi, timing);
  return static_cast<int>(made->bytes());
}

int biss_reader_read(const biss_reader* reader, const std::uint8_t* bytes, std::size_t size,
                     biss_sample* sample) {
  const auto& made = *std::launder(reinterpret_cast<const Reader*>(reader->storage));
  const auto frame = made.read(std::span(bytes, size));
  if (!frame.ok()) return error_of(frame.error().cause);
  if (!frame->trusted()) return -EFAULT;
  const biss::Channel& channel = frame->channels()[0];
  sample->position = channel.position;
  sample->warning = !channel.nW;
  sample->line_delay_clocks = biss::line_delay_clocks(*frame);
  return 0;
}
