#include "bench/pool.hpp"

#include <algorithm>

#include "biss/frame/encode.hpp"
#include "biss/frame/format_text.hpp"

namespace biss::bench {

Pool::Pool(std::string_view format, const Shape& shape) {
  const FrameCodec<> codec(parse_format(format).value());
  Random random(pool_seed);
  stride_ = shape.bytes != 0
                ? shape.bytes
                : (shape.lead_most + shape.ack_most + 3U + codec.payload_bits() + 7U) / 8U;
  bytes_.resize(pool_size * stride_);
  frames_.reserve(pool_size);
  for (std::size_t i = 0; i < pool_size; ++i) {
    Frame frame;
    frame.channel_count = codec.format().channel_count;
    frame.lead_clocks = static_cast<std::uint16_t>(
        shape.lead_least + random.below(shape.lead_most - shape.lead_least + 1U));
    frame.ack_clocks = static_cast<std::uint16_t>(
        shape.ack_least + random.below(shape.ack_most - shape.ack_least + 1U));
    for (std::size_t k = 0; k < frame.channel_count; ++k) {
      const ChannelFormat& channel = codec.format().channel_list[k];
      frame.channel_list[k].position = random.bits(channel.position_bits());
      frame.channel_list[k].life_counter =
          static_cast<std::uint32_t>(random.bits(channel.life_counter.bits));
      frame.channel_list[k].nE = random.bits(1) != 0;
      frame.channel_list[k].nW = random.bits(1) != 0;
    }
    const FrameBits line = encode_frame(frame, codec).value();
    std::copy(line.bytes().begin(), line.bytes().end(),
              bytes_.begin() + static_cast<std::ptrdiff_t>(i * stride_));
    frames_.push_back(frame);
  }
}

}  // namespace biss::bench
