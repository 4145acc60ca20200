// Hostile SPI buffers: every accepted frame lies within the buffer and the bounds, and is complete.
//
// Input: the format's number in frame_formats; the clock period above 100 ns in ns; bits 0…3 the
// least line delay in quarter periods; bit 0 the phase, bit 1 the tail's rule, bit 2 the timeout's
// rule, bits 3…7 the range of line delays in quarter periods; bits of padding; the longest ACK in
// clocks; clocks sent, high and low byte; then the buffer.
#include "biss/frame/codec.hpp"
#include "biss/master/spi_read.hpp"
#include "fuzz/frame_formats.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

using Codec = FrameCodec<CrcTable<4>>;

constexpr std::size_t header_bytes = 8;

SpiSetup setup_of(const std::uint8_t* header) {
  const Picoseconds period = nanoseconds(100 + header[1]);
  const Picoseconds least = period * (header[2] % 16) / 4;
  return {.period = period,
          .phase = (header[3] & 1U) != 0 ? SpiPhase::sample_on_rising : SpiPhase::sample_on_falling,
          .line_delay = {least, least + period * (header[3] >> 3U) / 4},
          .first_bit = header[4],
          .tail = (header[3] & 2U) != 0 ? SpiTail::ignored : SpiTail::must_stay_low,
          .no_error_flag = true,
          .unchecked = true};
}

DeviceTiming timing_of(const std::uint8_t* header, Picoseconds period) {
  return {.start_min = period * (header[5] / 16),
          .ack_max = period * header[5],
          .timeout = {(header[3] & 4U) != 0 ? TimeoutRule::cycle : TimeoutRule::fixed,
                      nanoseconds(31'250)}};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < header_bytes) return 0;
  const auto& codec = codec_of<Codec>(data[0]);
  const SpiSetup setup = setup_of(data);
  const SpiReader reader(codec, setup, timing_of(data, setup.period));
  const std::span<const std::uint8_t> bytes(data + header_bytes, size - header_bytes);
  const std::size_t clocks = data[6] * 256U + data[7];

  const auto frame = reader.read(bytes, clocks);
  if (!frame.ok()) {
    require(!name_of(frame.error().cause).empty());
    require(frame.error().channel < codec.format().channel_count);
    return 0;
  }
  const FrameBounds& bounds = reader.bounds();
  require(frame->lead_clocks >= bounds.lead_min_clocks);
  require(frame->lead_clocks <= bounds.lead_max_clocks);
  require(frame->ack_clocks >= bounds.ack_min_clocks);
  require(frame->ack_clocks <= bounds.ack_max_clocks);
  const LineDelayRange observed = observed_line_delay(*frame, setup);
  require(observed.min >= Picoseconds{} && observed.max > observed.min);
  // No format of the list has padding, so every bit can be given back.
  const BitView bits(bytes, setup.first_bit, clocks);
  const std::size_t zeros = bits.find(true, 0);
  require(zeros <= reader.bounds().late_max_clocks && zeros < frame->lead_clocks);
  check_given_back(*frame, bits, zeros, codec);
  return 0;
}
